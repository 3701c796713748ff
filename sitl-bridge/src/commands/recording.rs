//! A new recording for a flight.

use crate::tlog::TlogWriter;
use miette::{Result, miette};
use std::io::ErrorKind;
use std::path::Path;

/// Begins a recording.
///
/// # Errors
/// The file exists or cannot be made.
pub(super) fn create(path: &Path) -> Result<TlogWriter> {
    TlogWriter::create(path).map_err(|error| {
        if error.kind() == ErrorKind::AlreadyExists {
            let advice = "a recording is never written over: name another file, or move that one away";
            return miette!("{} exists, and {advice}", path.display());
        }
        miette!("the recording {} cannot be made: {error}", path.display())
    })
}
