//! Checkpoints: everything a run needs to go on exactly.
//!
//! ```text
//! 0   8  magic "COVEYRUN"
//! 8   4  format version, u32 little-endian (1)
//! 12  8  length n of the body, u64 little-endian
//! 20  n  body: postcard of [`Checkpoint`]
//! 20+n 4 CRC-32 (ISO-HDLC) of all bytes before, little-endian
//! ```

use crate::train::State;
use covey_report::atomic;
use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

const MAGIC: &[u8; 8] = b"COVEYRUN";
const VERSION: u32 = 1;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
const HEADER: usize = 20;
/// Checkpoints kept in a run folder: the newest.
const KEPT: usize = 3;

/// A run between two rounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// The settings, as TOML.
    pub settings: String,
    /// Networks, optimisers and counters.
    pub state: State,
}

/// Why a checkpoint cannot be used.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// There is none.
    #[error("{0} holds no checkpoint: the run ended before its first one; delete the run folder and start it anew")]
    None(PathBuf),
    /// It cannot be read.
    #[error("cannot read {path}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is damaged or of another version.
    #[error("{path} is {what}; delete it to go on from the checkpoint before")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: &'static str,
    },
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] atomic::WriteError),
    /// Old ones cannot be removed.
    #[error("cannot tidy up {path}")]
    Tidy {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl Checkpoint {
    /// Its bytes.
    ///
    /// # Panics
    /// Never: vectors of numbers always encode.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let body = postcard::to_stdvec(self).expect("numbers encode");
        let mut bytes = Vec::with_capacity(body.len() + HEADER + 4);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((body.len() as u64).to_le_bytes());
        bytes.extend(body);
        let sum = CRC.checksum(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    /// From bytes; the error says what is wrong with them.
    ///
    /// # Errors
    /// A few words: "not a checkpoint", "cut short" and so on.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, &'static str> {
        if !bytes.starts_with(MAGIC) {
            return Err("not a checkpoint of Covey");
        }
        let Some((content, sum)) = bytes.split_last_chunk::<4>().filter(|(c, _)| c.len() >= HEADER) else {
            return Err("cut short");
        };
        if content[8..12] != VERSION.to_le_bytes() {
            return Err("of another format version");
        }
        if content[12..HEADER] != ((content.len() - HEADER) as u64).to_le_bytes() {
            return Err("cut short or extended");
        }
        if u32::from_le_bytes(*sum) != CRC.checksum(content) {
            return Err("damaged (its checksum does not fit)");
        }
        postcard::from_bytes(&content[HEADER..]).map_err(|_| "unreadable")
    }

    /// Writes it into `folder` as `episode-N.ckpt` and removes all but the newest few.
    ///
    /// # Errors
    /// [`CheckpointError::Write`] leaves the older ones as they are.
    pub fn save(&self, folder: &Path, episodes: u64) -> Result<PathBuf, CheckpointError> {
        let path = folder.join(format!("episode-{episodes:010}.ckpt"));
        atomic::write(&path, &self.to_bytes())?;
        for old in list(folder)?.iter().rev().skip(KEPT) {
            std::fs::remove_file(old).map_err(|source| CheckpointError::Tidy { path: old.clone(), source })?;
        }
        Ok(path)
    }

    /// The newest one in `folder`.
    ///
    /// # Errors
    /// When there is none or the newest is not sound.
    pub fn newest(folder: &Path) -> Result<Self, CheckpointError> {
        let path = list(folder)?.pop().ok_or_else(|| CheckpointError::None(folder.to_owned()))?;
        let bytes = std::fs::read(&path).map_err(|source| CheckpointError::Read { path: path.clone(), source })?;
        Self::from_bytes(&bytes).map_err(|what| CheckpointError::Damaged { path, what })
    }
}

/// Checkpoints in a folder, oldest first.
fn list(folder: &Path) -> Result<Vec<PathBuf>, CheckpointError> {
    let read = |source| CheckpointError::Read { path: folder.to_owned(), source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(read)? {
        let path = entry.map_err(read)?.path();
        if path.extension().is_some_and(|e| e == "ckpt") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
