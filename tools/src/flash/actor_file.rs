//! The actor file that is to be flashed.

use std::fs;
use std::path::{Path, PathBuf};

use firmware_core::actor::{self, Actor};

use super::error::FlashError;
use crate::error::{Error, Result};

/// An actor file that has been checked: it loads, and its self-test passes.
pub struct ActorFile {
    /// Where the file is.
    pub path: PathBuf,
    /// The content hash of the actor, as neighbour messages carry it.
    pub content_hash: u64,
    /// The whole file.
    pub bytes: Vec<u8>,
}

impl ActorFile {
    /// Reads a file and checks it.
    ///
    /// # Errors
    /// The file cannot be read, is no actor file, or fails its self-test.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).map_err(Error::file(path))?;
        let actor = Actor::load(&bytes).map_err(|reason| FlashError::wrong_file(path, &reason))?;
        actor.self_test().map_err(|reason| FlashError::wrong_file(path, &reason))?;
        let content_hash = actor.content_hash();
        Ok(Self { path: path.into(), content_hash, bytes })
    }

    /// Computes the actor's signature over `cases` neighbourhoods on this computer.
    ///
    /// # Errors
    /// The bytes are no actor file any more.
    pub fn signature(&self, cases: u32) -> Result<u64> {
        let actor = Actor::load(&self.bytes).map_err(|reason| FlashError::wrong_file(&self.path, &reason))?;
        Ok(actor::fingerprint(&actor, cases))
    }
}
