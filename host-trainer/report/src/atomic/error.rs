//! Why a file was not written.

use crate::io_advice::advice;
use std::io;
use std::path::{Path, PathBuf};

/// What [`write`](super::write()) was doing when it failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Creating the temporary file.
    Create,
    /// Writing or syncing the temporary file.
    Write,
    /// Renaming it over the target.
    Rename,
    /// Syncing the folder, when the new file was already in place.
    SyncFolder,
}

impl Stage {
    /// What failed, before the name of the file.
    const fn action(self) -> &'static str {
        match self {
            Self::Create => "create a file beside",
            Self::Write => "write",
            Self::Rename => "replace",
            Self::SyncFolder => "sync the folder of",
        }
    }
}

/// A file could not be written. Says what failed and what to do, and has what the system said as
/// its source; the file of that name, if there was one, is as before (except at [`Stage::SyncFolder`]).
#[derive(Debug, thiserror::Error)]
#[error("cannot {} {}. {}", .stage.action(), .path.display(), self.help())]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// How far it got.
    pub stage: Stage,
    /// What the operating system reported.
    pub source: io::Error,
}

impl WriteError {
    /// What the user can do about it.
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

/// The folder that holds `path`; `.` for a bare name.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}
