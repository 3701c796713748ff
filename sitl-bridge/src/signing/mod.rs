//! MAVLink 2 message signing.
//!
//! A [`Key`] is shared by all authentic senders. A node has one [`Session`], which issues the
//! timestamps of its signatures and remembers the newest timestamp of each sender, and
//! one [`LinkSigning`] for each of its links. Because all links share the session, a frame
//! recorded on one link is refused as a replay on the other too.
//!
//! Every call is given the time; only [`Timestamp::now`] reads a clock.

mod key;
mod session;
mod state_file;
mod timestamp;

pub use key::{Key, KeyError};
pub use session::{LinkSigning, Session, SigningError, Unsigned};
pub use state_file::{StateFile, StateFileError};
pub use timestamp::Timestamp;
