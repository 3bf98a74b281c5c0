//! The firmware's log: defmt frames, which carry numbers only; the words are in the ELF file.

use std::path::Path;

use defmt_decoder::{DecodeError, Table};

use crate::error::InputError;

/// Decodes what a program logged into one line an entry: seconds, level, words.
///
/// # Errors
/// When one of the files cannot be read, or `elf` is not a program that logs with defmt.
pub fn decode(elf: &Path, log: &Path) -> Result<Vec<String>, InputError> {
    let program = std::fs::read(elf).map_err(|error| InputError::unreadable(elf, &error))?;
    let bytes = std::fs::read(log).map_err(|error| InputError::unreadable(log, &error))?;
    let no_log = |what: String| InputError::in_file(elf, what, "give the file of the firmware that runs");
    let table = Table::parse(&program)
        .map_err(|error| no_log(format!("has a log table of another version ({error})")))?
        .ok_or_else(|| no_log("has no log table".into()))?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(&bytes);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let time = frame.display_timestamp().map_or_else(String::new, |time| time.to_string());
                let level = frame.level().map_or("", |level| level.as_str());
                lines.push(format!("{time:>10} {level:<5} {}", frame.display_message()));
            }
            Err(DecodeError::UnexpectedEof) => return Ok(lines),
            // A damaged frame: the decoder has skipped it.
            Err(DecodeError::Malformed) => {}
        }
    }
}
