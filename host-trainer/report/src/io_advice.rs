//! Advice for the user when the operating system refuses to write.

use std::io;

/// What the user can do about an error of the operating system while writing in `folder`.
pub(crate) fn advice(error: &io::Error, folder: &str) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => format!("Make the folder first: mkdir -p {folder}"),
        io::ErrorKind::PermissionDenied => format!("Allow writing in {folder}, or choose another folder"),
        io::ErrorKind::ReadOnlyFilesystem => format!("{folder} is on a read-only file system: choose another folder"),
        io::ErrorKind::StorageFull => format!("Free space on the disk of {folder}, then run the same command again"),
        io::ErrorKind::QuotaExceeded => format!("Your quota on the disk of {folder} is used up: free space there"),
        io::ErrorKind::NotADirectory => format!("{folder} is a file, not a folder: choose another folder"),
        io::ErrorKind::IsADirectory => "There is a folder of that name: move it away".into(),
        _ => format!("Check the disk of {folder}"),
    }
}
