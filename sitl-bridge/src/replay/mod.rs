//! A recorded flight, decided again.
//!
//! What a node heard is fed from its tlog to a node of the same kind, at the recorded times; what
//! it then sends is held against what was sent. Decisions stand in the log by their setpoints: of
//! the flights that the 17 actions would have asked for, the nearest names the action that was
//! flown. A step's feature is in the log byte for byte, and depends on all that the UAV observed.
//! The operator's commands are carried out again where the log has them.
//!
//! ```text
//! RecordingInfo   which frames of the log the node sent and which it received, and its settings
//! Replay          the node, run again
//! ReplayCheck     its decisions against those that were flown
//! ```

mod check;
mod error;
mod notes;
mod recording_info;
mod runner;
mod stream;
mod times;

pub use check::{Difference, DifferenceKind, ReplayCheck, ReplayReport};
pub use error::RecordingError;
pub use recording_info::{RecordingInfo, Role};
pub use runner::Replay;
pub use stream::{Foreign, foreign};
