//! What can go wrong between host and board.

use firmware_core::pil::{MAX_POIS, RequestError, VERSION};

/// Why a request has no result.
#[derive(Debug, thiserror::Error)]
pub enum PilError {
    /// The stream cannot be opened, read or written.
    #[error("the line to the board failed: {0}")]
    Io(std::io::Error),
    /// The stream came to its end.
    #[error("the board's end of the line was closed")]
    Closed,
    /// No answer, however often it was asked.
    #[error(
        "the board did not answer '{request}' in {attempts} attempts: is it running, and is the line's speed right?"
    )]
    Silent {
        /// What was asked.
        request: &'static str,
        /// How often.
        attempts: u32,
    },
    /// The board speaks another version.
    #[error("the board speaks protocol version {0}, this program {VERSION}: update the older of the two")]
    Version(u8),
    /// The board did not do it.
    #[error(transparent)]
    Refused(RequestError),
    /// An intact answer of another kind, or one that cannot be read.
    #[error("the board's answer to '{request}' makes no sense: update the older of the two")]
    Unexpected {
        /// What was asked.
        request: &'static str,
    },
    /// More PoIs in view than a request holds.
    #[error("{0} PoIs in view, a request holds {MAX_POIS}")]
    TooManyPois(usize),
    /// The board counts the cases of its signature otherwise.
    #[error("the board lost count of its signature at {0} cases, perhaps it restarted: start again")]
    LostCount(u32),
}

// By hand: the message holds the cause already, which is then no source as well.
impl From<std::io::Error> for PilError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}
