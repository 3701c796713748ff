//! For the tests of flashing: scripts that stand in for other programs, and an actor file.

use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, process};

use super::actor_file::ActorFile;
use crate::workspace;

/// A shell script that stands in for a program. Dropping it removes the file.
pub struct Script(PathBuf);

impl Script {
    /// Writes a script with these commands.
    pub fn new(body: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("covey-script-{}-{}", process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = env::temp_dir().join(name);
        fs::write(&path, format!("#!/bin/sh\n{body}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        Self(path)
    }

    /// The path of the script.
    pub fn path(&self) -> String {
        self.0.display().to_string()
    }

    /// What the script wrote to the file `$0.log`; empty if it was not run.
    pub fn log(&self) -> String {
        fs::read_to_string(self.0.with_extension("log")).unwrap_or_default()
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
        let _ = fs::remove_file(self.0.with_extension("log"));
    }
}

/// One of the committed actor files.
pub fn sample() -> ActorFile {
    ActorFile::read(&workspace::root().join("firmware-core/tests/data/sample-gcn.actor")).unwrap()
}
