//! Reads input files whole, with a limit, and turns what the machine says into a sentence.
//!
//! Everything is parsed from memory: the parsers then know how many bytes there really are, and no header can talk
//! them into reserving more.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::InputError;

/// Largest JSON side file, bytes; the calibrations people write have a few kilobytes.
pub const MAX_JSON_BYTES: u64 = 16 << 20;

/// Longest piece of a file that an error message quotes, characters.
const MAX_QUOTED: usize = 40;

/// Reads a file of at most `limit` bytes. The size is checked before anything is reserved.
///
/// # Errors
/// When the file is missing, is a folder, cannot be read or is larger than `limit`.
pub fn read_whole(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    let unreadable = |error| InputError::unreadable(path, &error);
    let file = File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(InputError::in_file(path, "is a folder where a file is due", "name a file"));
    }
    if metadata.len() > limit {
        return Err(too_large(&path.display().to_string(), limit));
    }
    read_stream(file, &path.display().to_string(), limit)
}

/// Reads a stream of unknown length, at most `limit` bytes of it; `place` names it in errors.
///
/// # Errors
/// When reading fails or the stream has more than `limit` bytes.
pub fn read_stream(stream: impl Read, place: &str, limit: u64) -> Result<Vec<u8>, InputError> {
    let mut bytes = Vec::new();
    stream.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|error| {
        InputError::at(place, format!("cannot be read ({error})"), "check the path and its permissions")
    })?;
    if bytes.len() as u64 > limit {
        return Err(too_large(place, limit));
    }
    Ok(bytes)
}

fn too_large(place: &str, limit: u64) -> InputError {
    InputError::at(place, format!("has more than the {limit} bytes that are accepted"), "split or thin it")
}

/// Understands JSON; unknown keys are ignored. `place` names the bytes in errors, `remedy` says what they must hold.
///
/// # Errors
/// When the bytes are no JSON, lack a key or have one of another type (with line and column).
pub fn parse_json<T: DeserializeOwned>(place: &str, bytes: &[u8], remedy: &str) -> Result<T, InputError> {
    // Windows editors put a byte order mark in front, which JSON does not know.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    serde_json::from_slice(bytes)
        .map_err(|error| InputError::at(place, format!("cannot be understood ({error})"), remedy))
}

/// A piece of the file, quoted and shortened, for an error message.
pub fn quoted(text: &str) -> String {
    match text.char_indices().nth(MAX_QUOTED) {
        Some((end, _)) => format!("{:?}...", &text[..end]),
        None => format!("{text:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_without_end_is_cut_off() {
        let error = read_stream(std::io::repeat(b'1'), "standard input", 1000).unwrap_err();
        assert_eq!(
            error.to_string(),
            "standard input: has more than the 1000 bytes that are accepted; split or thin it"
        );
        assert_eq!(read_stream(&b"1234"[..], "standard input", 4).unwrap(), b"1234");
    }

    #[test]
    fn missing_files_folders_and_large_files_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let message = |name: &str| read_whole(&folder.path().join(name), 3).unwrap_err().to_string();
        assert!(message("none.ply").contains("none.ply: cannot be read (No such file"));
        assert!(message("").contains("is a folder where a file is due"));
        std::fs::write(folder.path().join("four"), "1234").unwrap();
        assert!(message("four").contains("more than the 3 bytes"));
    }

    #[test]
    fn quotes_are_short_and_printable() {
        assert_eq!(quoted("a\u{7}b"), "\"a\\u{7}b\"");
        assert_eq!(quoted(&"é".repeat(41)), format!("{:?}...", "é".repeat(40)));
    }
}
