//! Why a board does not do what it is asked.

use crate::actor::LoadError;
use serde::{Deserialize, Serialize};

/// Why a board has no actor that may fly. All but the first two and the last are those of
/// [`LoadError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, thiserror::Error)]
pub enum ActorError {
    /// Not started yet.
    #[error("the board has not loaded its actor")]
    NotLoaded,
    /// Something else.
    #[error("the board cannot load its actor")]
    Other,
    /// Too few bytes.
    #[error("the board's actor file is cut short; flash it again")]
    Truncated,
    /// Too many bytes.
    #[error("the board's actor file is too long; flash it again")]
    Extended,
    /// Something else is in its place.
    #[error("the board holds no actor file; flash one")]
    NotAnActor,
    /// Another format.
    #[error("the board's actor file is of another format; export it with the firmware's version")]
    Version,
    /// A damaged file.
    #[error("the board's actor file is damaged; flash it again")]
    Checksum,
    /// An unreadable record.
    #[error("the board's actor file cannot be read; export it again")]
    Malformed,
    /// Another observation.
    #[error("the board's actor wants another form of observation; train it again")]
    Observation,
    /// Unfit widths.
    #[error("the board's actor has widths that the firmware cannot fly; train it again")]
    Dimension,
    /// Weights do not fit the widths.
    #[error("the weights of the board's actor do not fit its widths; export it again")]
    Length,
    /// A number out of bounds.
    #[error("the board's actor has a number out of bounds; export it again")]
    OutOfRange,
    /// Unreadable self-test vectors.
    #[error("the self-test vectors of the board's actor cannot be read; export it again")]
    SelfTests,
    /// A wrong content hash.
    #[error("the content hash of the board's actor is wrong; export it again")]
    ContentHash,
    /// The self-test gave other logits than at export, in this vector.
    #[error("self-test vector {0} gives other logits on the board than when the actor was exported: do not fly")]
    SelfTest(u8),
}

impl From<LoadError> for ActorError {
    fn from(e: LoadError) -> Self {
        match e {
            LoadError::Truncated { .. } => Self::Truncated,
            LoadError::Extended { .. } => Self::Extended,
            LoadError::NotAnActor => Self::NotAnActor,
            LoadError::Version { .. } => Self::Version,
            LoadError::Checksum { .. } => Self::Checksum,
            LoadError::Malformed => Self::Malformed,
            LoadError::Observation { .. } => Self::Observation,
            LoadError::Dimension { .. } => Self::Dimension,
            LoadError::Length => Self::Length,
            LoadError::OutOfRange => Self::OutOfRange,
            LoadError::SelfTests => Self::SelfTests,
            LoadError::ContentHash => Self::ContentHash,
        }
    }
}

/// Why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, thiserror::Error)]
pub enum RequestError {
    /// The frame is of another version than the board's, which is given.
    #[error("the board speaks protocol version {0}: update the older of the two")]
    Version(u8),
    /// The frame is intact, but its record cannot be read.
    #[error("the board cannot read the request: update the older of the two")]
    Unreadable,
    /// There is no actor that may fly.
    #[error(transparent)]
    Actor(ActorError),
    /// No [`Request::Hello`](super::Request::Hello) since the board started.
    #[error("the board was not told whom it flies for, or it restarted: say hello first")]
    NotStarted,
    /// The neighbour message is none.
    #[error("the board was passed bytes that are no neighbour message")]
    Message,
    /// Not a whole number of PoIs, or more than [`super::MAX_POIS`].
    #[error("the request holds no whole number of PoIs, or too many")]
    Pois,
    /// Another step was observed last, or none.
    #[error("the step to decide was not observed last: observe it first")]
    NotObserved,
}
