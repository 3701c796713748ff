//! A folder for the files of running autopilots.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A folder of its own among the temporary files, removed when this is dropped unless it was kept.
#[derive(Debug)]
pub(super) struct RunFolder {
    path: PathBuf,
    kept: bool,
}

impl RunFolder {
    /// Makes the folder for world `index`.
    ///
    /// # Errors
    /// It cannot be made.
    pub(super) fn create(index: u64) -> io::Result<Self> {
        let base = std::env::temp_dir();
        for attempt in 0_u32.. {
            let path = base.join(format!("covey-sitl-{}-{index}-{attempt}", std::process::id()));
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path, kept: false }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Keeps the folder, and returns where it is.
    pub(super) fn keep(&mut self) -> &Path {
        self.kept = true;
        &self.path
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if !self.kept {
            // What is left is rubbish among temporary files.
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}
