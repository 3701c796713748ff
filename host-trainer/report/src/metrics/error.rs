//! What can go wrong with a metrics file.

use crate::io_advice::advice;
use std::io;
use std::path::{Path, PathBuf};

/// Why a metrics file cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// The file could not be opened, read or written.
    #[error("cannot {action} the metrics file {}. {help}", path.display())]
    File {
        /// What was being done.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What to do about it.
        help: String,
        /// What the operating system reported.
        source: io::Error,
    },
    /// A complete row is not of the type asked for.
    #[error("row {row} of {} cannot be read. Restore the file or delete that line", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// The row, counted from 1 as editors count lines.
        row: u64,
        /// What the parser reported.
        source: serde_json::Error,
    },
    /// A value cannot be written as JSON.
    #[error("a row for {} cannot be written as JSON", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the serialiser reported.
        source: serde_json::Error,
    },
    /// The file has fewer rows than had been written at the checkpoint.
    #[error(
        "{} has {found} complete rows, but the checkpoint was taken after row {wanted}. Resume from an earlier checkpoint",
        path.display()
    )]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Rows in the file.
        found: u64,
        /// Rows that were asked for.
        wanted: u64,
    },
}

/// [`MetricsError::File`] with advice for this error of the operating system.
pub(super) fn file_error(action: &'static str, path: &Path, source: io::Error) -> MetricsError {
    let help = match source.kind() {
        io::ErrorKind::AlreadyExists => "Resume that run, or choose another run folder".into(),
        io::ErrorKind::NotFound if action != "create" => "Check that this is a run folder".into(),
        _ => advice(&source, &path.parent().unwrap_or(Path::new(".")).display().to_string()),
    };
    MetricsError::File { action, path: path.into(), help, source }
}
