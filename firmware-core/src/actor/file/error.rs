//! What can be wrong with an actor file.

use super::envelope::VERSION;
use crate::actor::layer::LayerError;
use thiserror::Error;

/// Why a file is not a sound actor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LoadError {
    /// Fewer bytes than the header says, or than a header has.
    #[error("the actor file is cut short: {found} bytes of {expected}; copy or export it again")]
    Truncated {
        /// Bytes there should be.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// More bytes than the header says.
    #[error("{extra} bytes too many after the actor file; copy or export it again")]
    Extended {
        /// Bytes after the end.
        extra: usize,
    },
    /// The first bytes are not an actor file's.
    #[error("this is not an actor file (it does not begin with COVEYACT); make one with `host-trainer export`")]
    NotAnActor,
    /// Another format version.
    #[error("actor file format {found}, but this program reads format {VERSION}; export it again with this version")]
    Version {
        /// Version in the file.
        found: u16,
    },
    /// The checksum does not fit.
    #[error("the actor file is damaged (CRC-32 {found:08x}, computed {computed:08x}); copy or export it again")]
    Checksum {
        /// CRC in the file.
        found: u32,
        /// CRC of the bytes.
        computed: u32,
    },
    /// The checksum fits, but the record cannot be read.
    #[error("the actor file's record cannot be read although its checksum fits; export it again")]
    Malformed,
    /// Another form of the observation.
    #[error("the actor wants observation form {found}, this program builds form {built}; train one of that form")]
    Observation {
        /// Form in the file.
        found: u16,
        /// Form that this program builds.
        built: u16,
    },
    /// Widths that this program cannot fly.
    #[error("the actor's {what} is {found}, this program takes {allowed}; train it with fitting widths")]
    Dimension {
        /// Which width.
        what: &'static str,
        /// Width in the file.
        found: u16,
        /// What would do.
        allowed: &'static str,
    },
    /// Weights or tables of another length than the widths ask for.
    #[error("the actor's weights do not fit its widths; export it again")]
    Length,
    /// A bias or multiplier out of bounds, so sums could overflow.
    #[error("the actor has a bias or multiplier out of bounds; export it again")]
    OutOfRange,
    /// The self-test vectors cannot be read.
    #[error("the actor's self-test vectors cannot be read; export it again")]
    SelfTests,
    /// The content hash in the file is not that of its content.
    #[error("the actor's content hash does not fit its content; export it again")]
    ContentHash,
}

impl From<LayerError> for LoadError {
    fn from(e: LayerError) -> Self {
        match e {
            LayerError::Short => Self::Length,
            LayerError::OutOfRange => Self::OutOfRange,
        }
    }
}

/// Why a file could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StoreError {
    /// The buffer is too small.
    #[error("the buffer is too small for the actor file")]
    Full,
}
