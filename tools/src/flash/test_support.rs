//! For the tests of flashing: scripts that stand in for other programs, and an actor file.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;

use tempfile::TempDir;

use super::actor_file::ActorFile;
use crate::workspace;

/// A shell script that stands in for a program. Dropping it removes the file.
pub struct Script {
    folder: TempDir,
}

impl Script {
    /// Writes a script with these commands.
    pub fn new(body: &str) -> Self {
        let script = Self { folder: tempfile::tempdir().unwrap() };
        let file = script.file();
        fs::write(&file, format!("#!/bin/sh\n{body}\n")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
        script
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("program")
    }

    /// The path of the script.
    pub fn path(&self) -> String {
        self.file().display().to_string()
    }

    /// What the script wrote to the file `$0.log`; empty if it was not run.
    pub fn log(&self) -> String {
        fs::read_to_string(self.file().with_extension("log")).unwrap_or_default()
    }
}

/// One of the committed actor files.
pub fn sample() -> ActorFile {
    ActorFile::read(&workspace::root().join("firmware-core/tests/data/sample-gcn.actor")).unwrap()
}
