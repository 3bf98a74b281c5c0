//! Lines of a file that may turn from text into binary: numbered, trimmed, lossless in position.

use std::borrow::Cow;

/// Largest header of a PLY or PCD file, bytes. Real ones have hundreds; without a limit a file that is one endless
/// line of words would be taken apart in memory many times its size.
const MAX_HEADER_BYTES: usize = 1 << 20;

/// Walks the lines of `bytes`; a line ends at LF, and blanks (CR among them) around it are trimmed.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    /// No line is read beyond this many bytes.
    limit: usize,
    position: usize,
    number: usize,
}

/// One line.
pub(super) struct Line<'a> {
    /// Counted from 1, as editors do.
    pub(super) number: usize,
    /// Without surrounding blanks; bytes that are not UTF-8 are replaced.
    pub(super) text: Cow<'a, str>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, limit: bytes.len(), position: 0, number: 0 }
    }

    /// The lines of a header: as if the file ended after [`MAX_HEADER_BYTES`], until [`Self::leave_header`].
    pub(super) fn of_header(bytes: &'a [u8]) -> Self {
        Self { limit: bytes.len().min(MAX_HEADER_BYTES), ..Self::new(bytes) }
    }

    /// From here on lines may be anywhere in the file.
    pub(super) fn leave_header(&mut self) {
        self.limit = self.bytes.len();
    }

    /// The index of the first byte after the lines read so far.
    pub(super) fn offset(&self) -> usize {
        self.position
    }

    /// The bytes after the lines read so far.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.position..).unwrap_or_default()
    }

    /// The next line that is not blank.
    pub(super) fn next_filled(&mut self) -> Option<Line<'a>> {
        self.find(|line| !line.text.is_empty())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let rest = self.bytes.get(self.position..self.limit).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.position += length + 1;
        self.number += 1;
        Some(Line { number: self.number, text: String::from_utf8_lossy(rest[..length].trim_ascii()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_after_a_header_are_found_exactly() {
        let mut lines = Lines::new(b"a \r\n\n b\n\n\x00\xff");
        assert_eq!(lines.next().unwrap().text, "a");
        let b = lines.next_filled().unwrap();
        assert_eq!((b.number, b.text.as_ref(), lines.offset()), (3, "b", 8));
        assert_eq!(lines.rest(), b"\n\x00\xff");
        assert_eq!(lines.next_filled().unwrap().text, "\u{0}\u{fffd}");
        assert!(lines.next().is_none() && lines.rest().is_empty());
    }
}
