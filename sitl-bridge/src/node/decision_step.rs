//! A step of the decision loop: what it begins with, how far it is, what comes of it.

use super::decision::{Decision, StepStart};
use firmware_core::geometry::State;
use firmware_core::message::Message;
use firmware_core::neighbour_table::Moment;

/// A measured state on the map, with its time on both clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measurement {
    /// The common clock: Unix time, ms.
    pub common_ms: i64,
    /// `time_boot_ms`.
    pub boot_ms: u32,
    /// Position and velocity, ticks and ticks/step.
    pub state: State,
    /// Velocity east and north, m/s.
    pub velocity_mps: [f64; 2],
}

/// What a measurement led to.
#[derive(Clone, Debug, Default)]
pub(super) struct StepOutput {
    /// The step that started with it.
    pub started: Option<StepStart>,
    /// Messages to broadcast, in this order.
    pub messages: Vec<Message>,
    /// The decision that was due.
    pub decision: Option<Decision>,
}

/// A step under way.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Its number, and the common clock when it started.
    pub start: Moment,
    pub start_ms: i64,
    pub state: State,
    pub beacons: u32,
    /// Whether it is to be decided: the UAV was in the air when it started, at or after the epoch.
    pub is_active: bool,
    /// Whether the step before it was active too. In its first step a UAV cannot know who is there: it
    /// observes at the deadline.
    pub knows_others: bool,
    /// The decision as far as it is known after encoding.
    pub encoded: Option<Decision>,
    /// Whether features were told, so that those of others count.
    pub uses_features: bool,
    pub decided: bool,
}

/// Sequence numbers of one kind of message: the next, once one was sent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sequence(pub Option<u16>);

impl Sequence {
    /// The next number. The first follows from the common clock, in tenths of a second, so that a node
    /// that is restarted continues after the numbers that it used before.
    pub fn next(&mut self, common_ms: i64) -> u16 {
        let sequence = self.0.unwrap_or((common_ms / 100) as u16);
        self.0 = Some(sequence.wrapping_add(1));
        sequence
    }
}
