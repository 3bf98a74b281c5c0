//! The link's bytes in memory that host and board share: two rings, one in each direction.
//!
//! For bulk: an emulated UART carries some tens of kilobytes a second, memory carries what the emulator can compute.
//! The frames are the same. The doorbell is the write index of a ring: the reader sees it move.
//!
//! ```text
//! 0x00  MAGIC, written by the host before the board starts; anything else means: no rings, use the UART
//! 0x10  write index of the ring to the board     0x14  its read index
//! 0x18  write index of the ring to the host      0x1C  its read index
//! 0x1000  4096 bytes to the board                0x2000  4096 bytes to the host
//! ```
//!
//! Indices are little-endian u32 and count bytes since the start, wrapping; each is written by one side only.

/// "VSR1".
pub const MAGIC: u32 = 0x3152_5356;
/// Offset of [`MAGIC`].
pub const MAGIC_AT: u32 = 0x00;
/// Bytes in a ring.
pub const RING: u32 = 0x1000;
/// Bytes of all of it.
pub const LENGTH: u32 = 0x3000;

/// Where one ring lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ring {
    /// Offset of the index that the writer advances.
    pub write_at: u32,
    /// Offset of the index that the reader advances.
    pub read_at: u32,
    /// Offset of the bytes.
    pub bytes_at: u32,
}

/// Host to board.
pub const TO_BOARD: Ring = Ring { write_at: 0x10, read_at: 0x14, bytes_at: 0x1000 };
/// Board to host.
pub const TO_HOST: Ring = Ring { write_at: 0x18, read_at: 0x1C, bytes_at: 0x2000 };

/// Bytes that can be read; never more than [`RING`], whatever the memory says.
pub fn filled(write: u32, read: u32) -> u32 {
    let filled = write.wrapping_sub(read);
    if filled > RING { 0 } else { filled }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_wrap_and_nonsense_is_empty() {
        assert_eq!(filled(5, 5), 0);
        assert_eq!(filled(3, u32::MAX - 1), 5);
        assert_eq!(filled(RING, 0), RING);
        assert_eq!(filled(RING + 1, 0), 0);
        assert_eq!(filled(0, 1), 0);
    }
}
