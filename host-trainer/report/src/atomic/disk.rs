//! The file operations behind an atomic write.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// The file operations that [`write_on`](super::write_on) needs. [`RealDisk`] is the operating system; tests pass
/// others, which fail where they choose.
pub trait Disk {
    /// An open file.
    type File: Write;
    /// Creates a new file; fails when there is one of that name.
    ///
    /// # Errors
    /// What the operating system reports.
    fn create_new(&self, path: &Path) -> io::Result<Self::File>;
    /// Returns once the file's bytes are on the storage medium.
    ///
    /// # Errors
    /// What the operating system reports.
    fn sync(&self, file: &Self::File) -> io::Result<()>;
    /// Renames `from` to `to` atomically, replacing `to`.
    ///
    /// # Errors
    /// What the operating system reports.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;
    /// Returns once the folder's names are on the storage medium.
    ///
    /// # Errors
    /// What the operating system reports.
    fn sync_folder(&self, folder: &Path) -> io::Result<()>;
    /// Deletes a file.
    ///
    /// # Errors
    /// What the operating system reports.
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
