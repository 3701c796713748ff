//! What can be wrong with the bytes of a message.

use super::header::VERSION;
use crate::actor::{MAX_DEGREE, MAX_FEATURE};
use crate::geometry::COORDINATE_LIMIT;

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// Fewer bytes than the message says, or than any message has.
    #[error("{len} bytes where the message needs {needed}")]
    TooShort {
        /// Bytes there are.
        len: usize,
        /// Bytes there should be.
        needed: usize,
    },
    /// More bytes than the message says.
    #[error("{len} bytes where the message ends after {needed}")]
    TooLong {
        /// Bytes there are.
        len: usize,
        /// Bytes there should be.
        needed: usize,
    },
    /// Written by a sender of another version.
    #[error("message version {0}, this one reads version {VERSION}: update the older of the two")]
    UnknownVersion(u8),
    /// Neither a beacon nor a feature.
    #[error("unknown message kind {0}")]
    UnknownKind(u8),
    /// A coordinate beyond ±[`COORDINATE_LIMIT`].
    #[error("coordinate {0} is beyond ±{COORDINATE_LIMIT} ticks")]
    Position(i32),
    /// The tie-breaker −128.
    #[error("tie-breaker -128, the least is -127")]
    Tie,
    /// Not 1 to [`MAX_DEGREE`].
    #[error("degree {0} is not 1 to {MAX_DEGREE}")]
    Degree(u8),
    /// Not 1 to [`MAX_FEATURE`] values (more than 255 read as 255).
    #[error("{0} values, a feature has 1 to {MAX_FEATURE}")]
    Width(u8),
}
