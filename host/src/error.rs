//! The one error type of the host: what is wrong, where, and what to do about it.

use std::path::{Path, PathBuf};

/// Input or usage that cannot be worked with. Its message is one sentence for a person; the exit code is 2.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {what}; {remedy}")]
pub struct InputError {
    /// File (and line, header field, pixel or point where known), or the option of the command line.
    pub place: String,
    /// What is wrong, with the offending value.
    pub what: String,
    /// What the user can do.
    pub remedy: String,
}

impl InputError {
    /// A mistake found in `path`.
    pub fn in_file(path: &Path, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: path.display().to_string(), what: what.into(), remedy: remedy.into() }
    }

    /// A file that could not be read at all.
    pub fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        Self::in_file(path, format!("cannot be read ({error})"), "check the path and its permissions")
    }

    /// A mistake on the command line, in a configuration value, or in a stream without a name.
    pub fn at(place: impl Into<String>, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: place.into(), what: what.into(), remedy: remedy.into() }
    }
}

/// Writes a file whole or not at all: a temporary neighbour is filled, then renamed over `path`.
///
/// # Errors
/// When the folder cannot be written to; nothing is left behind.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(format!(".{}.part", std::process::id()));
    let temporary = PathBuf::from(temporary);
    let written = std::fs::write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|error| {
        let _ = std::fs::remove_file(&temporary);
        InputError::in_file(
            path,
            format!("cannot be written ({error})"),
            "check that its folder exists and is writable",
        )
    })
}
