//! Writing a file atomically.

use super::disk::{Disk, RealDisk};
use super::error::{Stage, WriteError, folder_of};
use crate::sync::lived_with;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

/// The end of the name of every temporary file, by which [`remove_leftovers`] knows those of a crash.
const TEMPORARY_SUFFIX: &str = ".covey-tmp";

/// Writes `bytes` as the whole content of `path`, or changes nothing.
///
/// A file system that refuses to sync (a share, for example) is lived with, and told on standard error once.
/// A symbolic link at `path` is replaced by the file, as by `mv`.
///
/// # Errors
/// [`WriteError`] when the folder is missing or not writable, or the disk is full; the old file is then intact and no
/// temporary file is left.
pub fn write(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), WriteError> {
    write_on(&RealDisk, path.as_ref(), bytes)
}

/// [`write()`] with the file operations of the caller's choice.
///
/// # Errors
/// As [`write()`].
pub fn write_on<D: Disk>(disk: &D, path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let error = |stage, source| WriteError { path: path.into(), stage, source };
    let Some(temporary) = temporary_beside(path) else {
        let source = io::Error::new(io::ErrorKind::IsADirectory, "the path names no file");
        return Err(error(Stage::Create, source));
    };
    let mut file = disk.create_new(&temporary).map_err(|e| error(Stage::Create, e))?;
    let written = file.write_all(bytes).and_then(|()| file.flush()).and_then(|()| lived_with(disk.sync(&file)));
    drop(file);
    let placed = written
        .map_err(|e| error(Stage::Write, e))
        .and_then(|()| disk.rename(&temporary, path).map_err(|e| error(Stage::Rename, e)));
    if placed.is_err() {
        // The first error is the one worth reporting; a leftover is only untidy.
        let _ = disk.remove(&temporary);
    }
    placed?;
    lived_with(disk.sync_folder(folder_of(path))).map_err(|e| error(Stage::SyncFolder, e))
}

/// Removes the temporary files that a killed process left in `folder`; returns how many. Call it only while no other
/// process writes there.
///
/// # Errors
/// When the folder cannot be read or a temporary file cannot be deleted.
pub fn remove_leftovers(folder: impl AsRef<Path>) -> io::Result<usize> {
    let mut removed = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_string_lossy().ends_with(TEMPORARY_SUFFIX) {
            fs::remove_file(entry.path())?;
            removed += 1;
        }
    }
    Ok(removed)
}

/// A name in the folder of `path` that no other write uses: it holds the process id and a count.
fn temporary_beside(path: &Path) -> Option<PathBuf> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name()?);
    name.push(format!(".{}-{count}{TEMPORARY_SUFFIX}", process::id()));
    Some(folder_of(path).join(name))
}
