//! Files that are either the old ones or the new ones, never half.
//!
//! [`write()`] puts the bytes in a temporary file of the same folder, syncs it,
//! renames it over the target and syncs the folder. A crash, a full disk or a
//! power cut at any moment leaves the target whole.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

/// Ends the name of every temporary file, so that a crash's leftovers are known.
const TEMPORARY_SUFFIX: &str = ".covey-tmp";

/// The file operations that [`write_on`] needs. [`RealDisk`] is the operating
/// system; tests give others, which fail where they choose.
pub trait Disk {
    /// An open file.
    type File: Write;
    /// Makes a new file; fails when the name is taken.
    ///
    /// # Errors
    /// As the operating system says.
    fn create_new(&self, path: &Path) -> io::Result<Self::File>;
    /// Returns once the file's bytes are on the medium.
    ///
    /// # Errors
    /// As the operating system says.
    fn sync(&self, file: &Self::File) -> io::Result<()>;
    /// Puts `from` in the place of `to` in one step.
    ///
    /// # Errors
    /// As the operating system says.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;
    /// Returns once the folder's names are on the medium.
    ///
    /// # Errors
    /// As the operating system says.
    fn sync_folder(&self, folder: &Path) -> io::Result<()>;
    /// Deletes a file.
    ///
    /// # Errors
    /// As the operating system says.
    fn remove(&self, path: &Path) -> io::Result<()>;
}

/// The operating system's files.
#[derive(Clone, Copy, Debug, Default)]
pub struct RealDisk;

impl Disk for RealDisk {
    type File = File;

    fn create_new(&self, path: &Path) -> io::Result<File> {
        OpenOptions::new().write(true).create_new(true).open(path)
    }

    fn sync(&self, file: &File) -> io::Result<()> {
        file.sync_all()
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn sync_folder(&self, folder: &Path) -> io::Result<()> {
        // Only Unix can open a folder to sync it; elsewhere the rename has to do.
        if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }
}

/// What [`write()`] was doing when it failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Making the temporary file.
    Create,
    /// Writing or syncing the temporary file.
    Write,
    /// Renaming it over the target.
    Rename,
    /// Syncing the folder, when the new file was already in place.
    SyncFolder,
}

/// A file could not be written. Says what failed and what to do, and has what the system said as
/// its source; the file of that name, if there was one, is as before (except at [`Stage::SyncFolder`]).
#[derive(Debug)]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// How far it got.
    pub stage: Stage,
    /// What the operating system said.
    pub source: io::Error,
}

impl WriteError {
    /// What the person at the keyboard can do about it.
    #[must_use]
    pub fn help(&self) -> String {
        let folder = folder_of(&self.path).display();
        if self.stage == Stage::SyncFolder {
            return "The new file is in place but may not survive a power cut: check the disk, then write again".into();
        }
        let advice = advice(&self.source, &folder.to_string());
        format!("{advice}. What {} held before is untouched", self.path.display())
    }
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.stage {
            Stage::Create => "create a file beside",
            Stage::Write => "write",
            Stage::Rename => "replace",
            Stage::SyncFolder => "sync the folder of",
        };
        write!(f, "cannot {what} {}. {}", self.path.display(), self.help())
    }
}

impl std::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

/// What to do about an error of the operating system while writing in `folder`.
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

/// Writes `bytes` as the whole content of `path`, or changes nothing.
///
/// A symbolic link at `path` is replaced by the file, as by `mv`.
///
/// # Errors
/// [`WriteError`] when the folder is missing or not writable, or the disk is full;
/// the old file is then intact and no temporary file stays behind.
pub fn write(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), WriteError> {
    write_on(&RealDisk, path.as_ref(), bytes)
}

/// As [`write()`], on a disk of the caller's choice.
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
    let written = file.write_all(bytes).and_then(|()| file.flush()).and_then(|()| disk.sync(&file));
    drop(file);
    let placed = written
        .map_err(|e| error(Stage::Write, e))
        .and_then(|()| disk.rename(&temporary, path).map_err(|e| error(Stage::Rename, e)));
    if placed.is_err() {
        // The first error is the one worth reporting; a leftover is only untidy.
        let _ = disk.remove(&temporary);
    }
    placed?;
    disk.sync_folder(folder_of(path)).map_err(|e| error(Stage::SyncFolder, e))
}

/// Removes the temporary files that a killed process left in `folder`; returns
/// how many. Call it only when no other process writes there.
///
/// # Errors
/// When the folder cannot be read or a leftover not be deleted.
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

/// The folder that holds `path`; `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A name in the folder of `path` that no other write uses: process and count.
fn temporary_beside(path: &Path) -> Option<PathBuf> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name()?);
    name.push(format!(".{}-{count}{TEMPORARY_SUFFIX}", process::id()));
    Some(folder_of(path).join(name))
}
