//! One frame: how a message looks on the wire.
//!
//! ```text
//! 0x00 | COBS( version u8, type u8, sequence u16, session u32, length u16, payload, CRC-32 u32 ) | 0x00
//! ```
//!
//! Little-endian throughout. The CRC (ISO-HDLC, the one of Ethernet and zlib) covers everything before it, so that a
//! damaged length or session number is caught as surely as a damaged payload. COBS leaves 0x00 unused inside a frame;
//! a delimiter stands at both ends, so that a frame whose end was lost does not take the next one with it.
//! This outer layout is the same in all versions: it is what lets two versions tell each other that they differ.

use cobs::CobsEncoder;
use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use postcard::ser_flavors::{Flavor, Size};
use serde::Serialize;

/// Version of the message types and payloads. Any change of either raises it.
pub const VERSION: u8 = 2;
/// Bytes before the payload.
pub const HEADER: usize = 10;
/// Bytes after it.
pub const CHECKSUM: usize = 4;
/// Largest payload, bytes: a frame with its delimiters then fits into 1024.
pub const MAX_PAYLOAD: usize = 1000;
/// Largest frame before byte stuffing.
pub const MAX_FRAME: usize = HEADER + MAX_PAYLOAD + CHECKSUM;
/// Largest frame on the wire: COBS adds one byte and another for every 254, the delimiters are two.
pub const MAX_WIRE: usize = cobs::max_encoding_length(MAX_FRAME) + 2;

/// CRC-32/ISO-HDLC, 1 KiB of table.
pub(crate) const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// The same in read-only memory, for digests that are kept between calls.
pub(crate) static CRC_TABLE: Crc<u32> = CRC;

/// What stands before the payload, but for its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// [`VERSION`] of the sender.
    pub version: u8,
    /// Message type, see [`super::message::kind`].
    pub kind: u8,
    /// Number of the message in its direction of the session, from 0, wrapping. In an answer: that of the message answered.
    pub sequence: u16,
    /// Session, chosen by the host when it says Hello. Never 0.
    pub session: u32,
}

/// An undamaged frame. The payload is not yet looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// What stands before the payload.
    pub header: Header,
    /// At most [`MAX_PAYLOAD`] bytes.
    pub payload: &'a [u8],
}

/// Why bytes between two delimiters are no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// Fewer bytes than header and checksum.
    Short,
    /// The checksum does not fit the bytes.
    Checksum,
    /// The checksum fits, the length field does not: written by something that is not this protocol.
    Length,
}

/// The message does not fit into a frame or into the buffer given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooLong;

/// Writes one frame with both delimiters to `wire` and returns how many bytes it takes (at most [`MAX_WIRE`]).
///
/// The payload is encoded twice, once to learn its length, which stands before it, and once through checksum and byte
/// stuffing straight into `wire`: that costs some cycles and saves a second buffer of a kilobyte.
///
/// # Errors
/// [`TooLong`] when the payload exceeds [`MAX_PAYLOAD`] or the frame `wire`.
pub fn encode(header: &Header, payload: &impl Serialize, wire: &mut [u8]) -> Result<usize, TooLong> {
    let length = postcard::serialize_with_flavor(payload, Size::default()).map_err(|_| TooLong)?;
    if length > MAX_PAYLOAD {
        return Err(TooLong);
    }
    let (start, rest) = wire.split_first_mut().ok_or(TooLong)?;
    *start = 0;
    let mut stuffing = Stuffing { encoder: CobsEncoder::new(rest), digest: CRC_TABLE.digest() };
    for field in [
        &[header.version, header.kind][..],
        &header.sequence.to_le_bytes(),
        &header.session.to_le_bytes(),
        &(length as u16).to_le_bytes(),
    ] {
        stuffing.push(field)?;
    }
    let stuffed = postcard::serialize_with_flavor(payload, stuffing).map_err(|_| TooLong)?;
    let end = wire.get_mut(1 + stuffed).ok_or(TooLong)?;
    *end = 0;
    Ok(stuffed + 2)
}

/// Checks what stood between two delimiters, byte stuffing removed.
///
/// # Errors
/// What is wrong with it. The version is not judged here: the layout is common to all versions.
pub fn decode(bytes: &[u8]) -> Result<Frame<'_>, Damage> {
    let (content, checksum) = bytes.split_last_chunk::<CHECKSUM>().ok_or(Damage::Short)?;
    let (header, payload) = content.split_first_chunk::<HEADER>().ok_or(Damage::Short)?;
    if CRC_TABLE.checksum(content) != u32::from_le_bytes(*checksum) {
        return Err(Damage::Checksum);
    }
    let [
        version,
        kind,
        sequence_0,
        sequence_1,
        session_0,
        session_1,
        session_2,
        session_3,
        length_0,
        length_1,
    ] = *header;
    if usize::from(u16::from_le_bytes([length_0, length_1])) != payload.len() {
        return Err(Damage::Length);
    }
    let sequence = u16::from_le_bytes([sequence_0, sequence_1]);
    let session = u32::from_le_bytes([session_0, session_1, session_2, session_3]);
    Ok(Frame { header: Header { version, kind, sequence, session }, payload })
}

/// Where postcard's bytes go: through the checksum and the byte stuffing into the wire buffer.
struct Stuffing<'a> {
    encoder: CobsEncoder<'a>,
    digest: Digest<'static, u32>,
}

impl Stuffing<'_> {
    fn push(&mut self, bytes: &[u8]) -> Result<(), TooLong> {
        self.digest.update(bytes);
        self.encoder.push(bytes).map_err(|_| TooLong)
    }
}

impl Flavor for Stuffing<'_> {
    /// Stuffed length, checksum included, delimiters not.
    type Output = usize;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.push(bytes).map_err(|_| postcard::Error::SerializeBufferFull)
    }

    fn finalize(mut self) -> postcard::Result<usize> {
        let checksum = self.digest.finalize().to_le_bytes();
        self.encoder.push(&checksum).map_err(|_| postcard::Error::SerializeBufferFull)?;
        Ok(self.encoder.finalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER_OF_TEST: Header =
        Header { version: VERSION, kind: 0x15, sequence: 0x1234, session: 0xDEAD_BEEF };

    #[test]
    fn the_layout_is_the_one_of_the_specification() {
        let mut wire = [0xAA; MAX_WIRE];
        let used = encode(&HEADER_OF_TEST, &(7_u8, 0_u8), &mut wire).unwrap();
        let mut content = [0; 32];
        let report = cobs::decode(&wire[1..used], &mut content).unwrap();
        assert_eq!(wire[0], 0);
        assert_eq!(wire[used - 1], 0);
        assert!(!wire[1..used - 1].contains(&0));
        let content = &content[..report.frame_size()];
        assert_eq!(content[..12], [VERSION, 0x15, 0x34, 0x12, 0xEF, 0xBE, 0xAD, 0xDE, 2, 0, 7, 0]);
        assert_eq!(content[12..], CRC.checksum(&content[..12]).to_le_bytes());
        // The check value of the CRC catalogue.
        assert_eq!(CRC.checksum(b"123456789"), 0xCBF4_3926);
        let frame = decode(content).unwrap();
        assert_eq!(frame, Frame { header: HEADER_OF_TEST, payload: &[7, 0] });
    }

    #[test]
    fn every_damaged_byte_and_every_truncation_is_noticed() {
        let mut wire = [0; 64];
        let used = encode(&HEADER_OF_TEST, &0x0102_0304_u32, &mut wire).unwrap();
        let mut content = [0; 64];
        let size = cobs::decode(&wire[1..used], &mut content).unwrap().frame_size();
        for at in 0..size {
            for bit in 0..8 {
                let mut damaged = content;
                damaged[at] ^= 1 << bit;
                assert_eq!(decode(&damaged[..size]), Err(Damage::Checksum));
            }
            assert!(decode(&content[..at]).is_err());
        }
        assert_eq!(decode(&[]), Err(Damage::Short));
    }

    #[test]
    fn a_length_that_lies_is_noticed_even_under_a_good_checksum() {
        let mut content = [1, 2, 0, 0, 1, 0, 0, 0, 3, 0, 9, 9, 0, 0, 0, 0];
        let checksum = CRC.checksum(&content[..12]).to_le_bytes();
        content[12..].copy_from_slice(&checksum);
        assert_eq!(decode(&content), Err(Damage::Length));
    }

    #[test]
    fn the_largest_payload_fits_and_one_byte_more_does_not() {
        let bytes = [0x55_u8; MAX_PAYLOAD];
        let mut wire = [0; MAX_WIRE];
        // A slice is encoded with two bytes of length before it.
        assert!(encode(&HEADER_OF_TEST, &&bytes[..MAX_PAYLOAD - 2], &mut wire).unwrap() <= MAX_WIRE);
        assert_eq!(encode(&HEADER_OF_TEST, &&bytes[..MAX_PAYLOAD - 1], &mut wire), Err(TooLong));
        for room in 0..18 {
            assert_eq!(encode(&HEADER_OF_TEST, &0_u32, &mut wire[..room]), Err(TooLong));
        }
    }
}
