//! The board's answers, in types of a host.

use firmware_core::neighbour_table::MessageOutcome;
use firmware_core::pil::{ActorError, ActorInfo, Report};

/// What a board reports about itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardReport {
    /// Version of its firmware, such as `0.1.0`.
    pub software: String,
    /// Its actor, or the fault that keeps it from flying.
    pub actor: Result<ActorInfo, ActorError>,
}

impl From<Report<'_>> for BoardReport {
    fn from(r: Report<'_>) -> Self {
        Self { software: r.software.to_owned(), actor: r.actor }
    }
}

/// What the board's neighbour table did with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HearOutcome {
    /// The table's answer. [`MessageOutcome::Repeated`] can also mean that the reply to a first attempt was lost.
    pub outcome: MessageOutcome,
    /// Number of UAVs in the table now.
    pub kept: u8,
}

/// What the board made of a step that it observed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Observed {
    /// Degree: neighbours in range and the UAV itself, 1 to 17.
    pub degree: u8,
    /// The UAV's tie-breaker of the step.
    pub tie: i8,
    /// The encoded feature message to broadcast; empty when the policy uses no features of others.
    pub message: Vec<u8>,
}
