//! The phases of a flight.

use super::reason::Reason;

/// Where a flight stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The vehicle is not ours, and why; only the operator's [`Request::Start`](super::Request::Start) changes that.
    Idle(Reason),
    /// The operator asked for a flight, and the vehicle is not yet in the air and in GUIDED.
    BringUp,
    /// In the air.
    Flight,
    /// Told to return home, and why.
    Returning(Reason),
}
