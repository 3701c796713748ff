//! Reading a metrics file.

use super::error::{MetricsError, file_error};
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads every complete row. A last line without a newline is not a row yet and is left out: the run may still be
/// writing it, or was killed while it did.
///
/// # Errors
/// [`MetricsError::Row`] when a complete row is not a `T`, or [`MetricsError::File`].
pub fn read<T: DeserializeOwned>(path: impl AsRef<Path>) -> Result<Vec<T>, MetricsError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|e| file_error("read", path, e))?;
    let complete = newlines(&bytes).last().map_or(0, |at| at + 1);
    let lines = bytes[..complete].split_inclusive(|&b| b == b'\n');
    let row = |(index, line)| {
        serde_json::from_slice(line).map_err(|source| MetricsError::Row {
            path: path.into(),
            row: index as u64 + 1,
            source,
        })
    };
    lines.enumerate().map(row).collect()
}

/// Offsets of the newlines in `bytes`.
pub(super) fn newlines(bytes: &[u8]) -> impl Iterator<Item = usize> {
    bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(at, _)| at)
}
