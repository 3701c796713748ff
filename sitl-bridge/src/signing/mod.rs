//! MAVLink 2 message signing.
//!
//! A [`Key`] is shared by those who may be believed. A node has one [`Session`], which keeps
//! the time of what it signs and remembers the newest timestamp of every sender it heard, and
//! one [`LinkSigning`] for each of its links. Because all links share the session, a frame
//! recorded on one link is refused as a replay on the other too.
//!
//! Nothing here reads a clock: every call is told the time.

mod key;
mod session;
mod state_file;
mod timestamp;

pub use key::{Key, KeyError};
pub use session::{LinkSigning, Session, SigningError, Unsigned};
pub use state_file::{StateFile, StateFileError};
pub use timestamp::Timestamp;
