//! What a board answers: postcard records.

use super::error::{ActorError, RequestError};
use super::status::Status;
use crate::actor::{Aggregation, Logits};
use crate::neighbour_table::MessageOutcome;
use serde::{Deserialize, Serialize};

/// What a board answers. The order of the variants is part of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reply<'a> {
    /// What the board runs; also sent unasked when it starts.
    #[serde(borrow)]
    Report(Report<'a>),
    /// A message was heard.
    Heard {
        /// What became of it.
        outcome: MessageOutcome,
        /// UAVs in the table now.
        kept: u8,
    },
    /// The step is observed and encoded.
    Observed(Observed<'a>),
    /// The step is decided.
    Decided(Decided),
    /// How the board and the line are.
    Status(Status),
    /// The signature in progress.
    Signature {
        /// Cases so far.
        cases: u32,
        /// Its value.
        value: u64,
    },
    /// The request was read but not done.
    Refused(RequestError),
}

/// What a board runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report<'a> {
    /// Version of the firmware.
    pub software: &'a str,
    /// Its actor, or why it has none that may fly.
    pub actor: Result<ActorInfo, ActorError>,
}

/// An actor that passed its self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActorInfo {
    /// Content hash of the file.
    pub content_hash: u64,
    /// Form of its observation.
    pub observation: u16,
    /// How it combines features.
    pub aggregation: Aggregation,
    /// Values of the feature it broadcasts; 0 when it broadcasts none.
    pub width: u8,
    /// Steps for which a tie-breaker holds.
    pub tie_period: u32,
}

/// An observed step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observed<'a> {
    /// The step.
    pub step: u32,
    /// Neighbours in view and the UAV itself, 1 to 17.
    pub degree: u8,
    /// The UAV's tie-breaker of the step, for its next beacons.
    pub tie: i8,
    /// The feature message to broadcast; empty when the policy broadcasts none. Its
    /// sequence number is the step's low half.
    pub message: &'a [u8],
}

/// A decided step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decided {
    /// The step.
    pub step: u32,
    /// Index of the action, 0 to 16.
    pub action: u8,
    /// Neighbours whose features counted.
    pub features: u8,
    /// The logits.
    pub logits: Logits,
}
