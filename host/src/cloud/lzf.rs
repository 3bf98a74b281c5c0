//! LZF decompression (the format of Marc Lehmann's LibLZF), which PCD `binary_compressed` uses.
//!
//! A control byte below 32 is followed by that many plus one literal bytes. Any other repeats earlier output: its upper
//! three bits hold the length less two (7: one more byte is added to it), its lower five and the byte after them
//! the distance less one.
//!
//! Ours, because it is a page, must be safe on hostile bytes, and the package for it is no longer kept.

/// Output bytes that one input byte can stand for at most: 264 bytes from the three of the longest repeat.
pub(super) const MAX_RATIO: usize = 88;

/// Why compressed bytes make no sense.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Corrupt {
    /// The input ends inside an instruction.
    Cut,
    /// A repeat reaches back before the first byte of output.
    BeforeStart,
    /// The output has another length than announced.
    Length,
}

/// Decompresses `packed` into exactly `length` bytes; reserves no more than [`MAX_RATIO`] times the input.
pub(super) fn decompress(packed: &[u8], length: usize) -> Result<Vec<u8>, Corrupt> {
    if length > packed.len().saturating_mul(MAX_RATIO) {
        return Err(Corrupt::Length);
    }
    let mut output = Vec::with_capacity(length);
    let mut input = packed;
    while let Some(control) = next(&mut input) {
        if control < 32 {
            let (literals, rest) = input.split_at_checked(control + 1).ok_or(Corrupt::Cut)?;
            if literals.len() > length - output.len() {
                return Err(Corrupt::Length);
            }
            output.extend_from_slice(literals);
            input = rest;
            continue;
        }
        let extra = if control >> 5 == 7 { next(&mut input).ok_or(Corrupt::Cut)? } else { 0 };
        let run = 2 + (control >> 5) + extra;
        let distance = 1 + ((control & 31) << 8) + next(&mut input).ok_or(Corrupt::Cut)?;
        let start = output.len().checked_sub(distance).ok_or(Corrupt::BeforeStart)?;
        if run > length - output.len() {
            return Err(Corrupt::Length);
        }
        // Byte by byte: a run may overlap its own output.
        for index in start..start + run {
            output.push(output[index]);
        }
    }
    if output.len() == length { Ok(output) } else { Err(Corrupt::Length) }
}

/// Takes one byte off the front.
fn next(input: &mut &[u8]) -> Option<usize> {
    let (&byte, rest) = input.split_first()?;
    *input = rest;
    Some(usize::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_repeats_and_overlaps() {
        assert_eq!(decompress(&[2, b'a', b'b', b'c'], 3).unwrap(), b"abc");
        // "abc", then 3 bytes from distance 3, then 4 from distance 1 (overlapping).
        assert_eq!(decompress(&[2, b'a', b'b', b'c', 1 << 5, 2, 2 << 5, 0], 10).unwrap(), b"abcabccccc");
        // The longest repeat: 7 + 255 + 2 bytes.
        assert_eq!(decompress(&[0, b'z', 7 << 5, 255, 0], 265).unwrap(), vec![b'z'; 265]);
    }

    #[test]
    fn corrupt_input_is_named() {
        assert_eq!(decompress(&[2, b'a', b'b'], 3), Err(Corrupt::Cut));
        assert_eq!(decompress(&[0, b'a', 7 << 5], 9), Err(Corrupt::Cut));
        assert_eq!(decompress(&[0, b'a', 1 << 5, 1], 4), Err(Corrupt::BeforeStart));
        assert_eq!(decompress(&[1, b'a', b'b'], 3), Err(Corrupt::Length));
        assert_eq!(decompress(&[1, b'a', b'b'], 1), Err(Corrupt::Length));
        assert_eq!(decompress(&[0, b'a', 7 << 5, 255, 0], 200), Err(Corrupt::Length));
        assert_eq!(decompress(&[], usize::MAX), Err(Corrupt::Length));
        assert_eq!(decompress(&[], 0), Ok(vec![]));
    }
}
