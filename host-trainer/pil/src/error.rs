//! Errors between host and board.

use firmware_core::pil::{MAX_POIS, RequestError, VERSION};

/// Why a request to a board failed.
#[derive(Debug, thiserror::Error)]
pub enum PilError {
    /// The stream cannot be opened, read or written.
    #[error("the line to the board failed: {0}")]
    Io(std::io::Error),
    /// The stream ended.
    #[error("the board's end of the line was closed")]
    Closed,
    /// No answer in all attempts.
    #[error(
        "the board did not answer '{request}' in {attempts} attempts: is it running, and is the line's speed right?"
    )]
    Silent {
        /// The request.
        request: &'static str,
        /// Number of attempts.
        attempts: u32,
    },
    /// The board uses another version of the protocol.
    #[error("the board speaks protocol version {0}, this program {VERSION}: update the older of the two")]
    Version(u8),
    /// The board refused the request.
    #[error(transparent)]
    Refused(RequestError),
    /// An intact answer of another kind, or one that cannot be read.
    #[error("the board's answer to '{request}' makes no sense: update the older of the two")]
    Unexpected {
        /// The request.
        request: &'static str,
    },
    /// More PoIs in view than a request holds.
    #[error("{0} PoIs in view, a request holds {MAX_POIS}")]
    TooManyPois(usize),
    /// The board has another count of the cases of its fingerprint.
    #[error("the board lost count of its fingerprint at {0} cases, perhaps it restarted: start again")]
    LostCount(u32),
}

// Not by #[from]: the message holds the cause already, so it is no source as well.
impl From<std::io::Error> for PilError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}
