//! Bytes in, frames out: removes the byte stuffing as the bytes arrive and keeps at most one frame.
//!
//! A 0x00 always ends what came before it and starts afresh, whatever that was. So damage costs the frame it is in.

use super::frame::{self, Damage, Frame, MAX_FRAME};
use cobs::{DecodeResult, DecoderState};

/// What was dropped since the start; every counter stays at its maximum when it is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DamageCount {
    /// Frames that ended before their byte stuffing did, or were shorter than header and checksum.
    pub truncated: u32,
    /// Frames longer than [`MAX_FRAME`].
    pub oversized: u32,
    /// Frames with a wrong checksum or a length that contradicts it.
    pub corrupted: u32,
}

/// The state between two bytes: about one frame of memory.
#[derive(Debug)]
pub struct FrameReceiver {
    stuffing: DecoderState,
    buffer: [u8; MAX_FRAME],
    length: usize,
    oversized: bool,
    damage: DamageCount,
}

impl FrameReceiver {
    /// Empty, as after a delimiter.
    pub const fn new() -> Self {
        Self {
            stuffing: DecoderState::Idle,
            buffer: [0; MAX_FRAME],
            length: 0,
            oversized: false,
            damage: DamageCount { truncated: 0, oversized: 0, corrupted: 0 },
        }
    }

    /// Takes one byte; the frame it completed, if it did. `O(1)`, and one checksum when a frame ends.
    pub fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        match self.stuffing.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataStart) => {
                self.length = 0;
                self.oversized = false;
                None
            }
            Ok(DecodeResult::DataContinue(decoded)) => {
                match self.buffer.get_mut(self.length) {
                    Some(slot) => {
                        *slot = decoded;
                        self.length += 1;
                    }
                    None => self.oversized = true,
                }
                None
            }
            Ok(DecodeResult::DataComplete) => self.complete(),
            Err(_) => {
                let counter =
                    if self.oversized { &mut self.damage.oversized } else { &mut self.damage.truncated };
                *counter = counter.saturating_add(1);
                None
            }
        }
    }

    /// What was dropped so far.
    pub fn damage(&self) -> DamageCount {
        self.damage
    }

    fn complete(&mut self) -> Option<Frame<'_>> {
        if self.oversized {
            self.damage.oversized = self.damage.oversized.saturating_add(1);
            return None;
        }
        match frame::decode(self.buffer.get(..self.length)?) {
            Ok(frame) => Some(frame),
            Err(damage) => {
                let counter = match damage {
                    Damage::Short => &mut self.damage.truncated,
                    Damage::Checksum | Damage::Length => &mut self.damage.corrupted,
                };
                *counter = counter.saturating_add(1);
                None
            }
        }
    }
}

impl Default for FrameReceiver {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::super::frame::{Header, MAX_WIRE, VERSION, encode};
    use super::*;

    fn wire_of(sequence: u16) -> ([u8; MAX_WIRE], usize) {
        let mut wire = [0; MAX_WIRE];
        let header = Header { version: VERSION, kind: 1, sequence, session: 5 };
        let used = encode(&header, &[sequence, 0, 0xFFFF], &mut wire).unwrap();
        (wire, used)
    }

    fn sequences(receiver: &mut FrameReceiver, bytes: impl IntoIterator<Item = u8>) -> heapless::Vec<u16, 8> {
        let mut found = heapless::Vec::new();
        for byte in bytes {
            if let Some(frame) = receiver.push(byte) {
                found.push(frame.header.sequence).unwrap();
            }
        }
        found
    }

    #[test]
    fn a_frame_without_its_end_costs_only_itself() {
        let (first, used) = wire_of(1);
        let (second, second_used) = wire_of(2);
        for kept in 2..used - 1 {
            let mut receiver = FrameReceiver::new();
            let bytes = first[..kept].iter().chain(&second[..second_used]).copied();
            assert_eq!(sequences(&mut receiver, bytes).as_slice(), [2], "{kept} bytes kept");
            let damage = receiver.damage();
            assert_eq!(damage.truncated + damage.corrupted, 1, "{kept} bytes kept: {damage:?}");
        }
    }

    #[test]
    fn an_endless_frame_is_dropped_and_the_next_one_is_read() {
        let mut receiver = FrameReceiver::new();
        assert!(sequences(&mut receiver, core::iter::repeat_n(0xFF, 100_000)).is_empty());
        let (wire, used) = wire_of(3);
        assert_eq!(sequences(&mut receiver, wire[..used].iter().copied()).as_slice(), [3]);
        assert_eq!(receiver.damage(), DamageCount { oversized: 1, ..DamageCount::default() });
    }

    #[test]
    fn silence_and_single_delimiters_are_not_damage() {
        let mut receiver = FrameReceiver::new();
        let (wire, used) = wire_of(4);
        let bytes = [0; 9].into_iter().chain(wire[..used].iter().copied()).chain([0; 9]);
        assert_eq!(sequences(&mut receiver, bytes).as_slice(), [4]);
        assert_eq!(receiver.damage(), DamageCount::default());
    }
}
