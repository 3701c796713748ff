//! What a node tells about itself: steps, decisions and counts.

use firmware_core::gate::Limited;
use firmware_core::geometry::State;
use firmware_core::hash::Fnv1a;
use firmware_core::neighbour_table::MessageOutcome;
use firmware_core::observation::{MAX_NEIGHBOURS, Observation};
use std::collections::BTreeMap;

/// A step began: where the UAV was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepBegun {
    /// The step.
    pub step: u32,
    /// Measured state at the first telemetry of the step.
    pub state: State,
    /// Common clock then, ms.
    pub common_ms: i64,
}

/// One decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The step.
    pub step: u32,
    /// Time of the vehicle when it was made, ms.
    pub boot_ms: u32,
    /// How long after the step's beginning, ms.
    pub phase_ms: u32,
    /// The state it was made on.
    pub state: State,
    /// [`observation_hash`] of the observation.
    pub observation: u64,
    neighbours: [u16; MAX_NEIGHBOURS],
    count: u8,
    /// How many of the neighbours in view sent a feature young enough.
    pub features: u8,
    /// Index of the action.
    pub action: u8,
    /// Whether it came later than a telemetry period after its time.
    pub late: bool,
}

impl Decision {
    /// One without neighbours that coasts.
    pub(super) const fn new(step: u32, state: State, observation: u64) -> Self {
        let neighbours = [0; MAX_NEIGHBOURS];
        let (boot_ms, phase_ms, count, features, action, late) = (0, 0, 0, 0, 16, false);
        Self { step, boot_ms, phase_ms, state, observation, neighbours, count, features, action, late }
    }

    pub(super) fn set_neighbours(&mut self, ids: impl Iterator<Item = u16>) {
        self.count = 0;
        for (slot, id) in self.neighbours.iter_mut().zip(ids) {
            *slot = id;
            self.count += 1;
        }
    }

    /// Ids of the neighbours in view, nearest first.
    #[must_use]
    pub fn neighbours(&self) -> &[u16] {
        &self.neighbours[..usize::from(self.count)]
    }
}

/// FNV-1a over the observation: the same on every computer, and enough to tell two apart.
#[must_use]
pub fn observation_hash(observation: &Observation) -> u64 {
    let mut hash = Fnv1a::new();
    observation.iter().for_each(|v| hash.write(&v.to_le_bytes()));
    hash.finish()
}

/// How often things happened.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Decisions made.
    pub decisions: u64,
    /// … of them late.
    pub late_decisions: u64,
    /// Steps in the air that ended without a decision.
    pub missed_decisions: u64,
    /// Setpoints sent.
    pub setpoints: u64,
    /// … of them changed by the gate.
    pub limited_setpoints: u64,
    /// … by what it changed: speed, acceleration, fence, altitude.
    pub limited: [u64; 4],
    /// Neighbour messages sent.
    pub sent: u64,
    /// Neighbour messages that the table took.
    pub received: u64,
    /// What came in and was not used, by reason: the links' and the neighbour table's.
    pub rejected: BTreeMap<&'static str, u64>,
}

impl Counters {
    /// A setpoint was sent.
    pub(super) fn setpoint(&mut self, limited: Limited) {
        self.setpoints += 1;
        self.limited_setpoints += u64::from(limited.any());
        let kinds = [limited.speed, limited.acceleration, limited.fence, limited.altitude];
        self.limited.iter_mut().zip(kinds).for_each(|(count, changed)| *count += u64::from(changed));
    }

    /// What the gate changed, with names.
    #[must_use]
    pub fn limits(&self) -> BTreeMap<&'static str, u64> {
        ["speed", "acceleration", "fence", "altitude"].into_iter().zip(self.limited).collect()
    }

    pub(super) fn answer(&mut self, answer: MessageOutcome) {
        if answer.is_taken() {
            self.received += 1;
        } else {
            *self.rejected.entry(answer_name(answer)).or_default() += 1;
        }
    }

    /// As one JSON object, in the summary's words.
    #[must_use]
    pub fn to_json(&self, uavs: u16) -> serde_json::Value {
        serde_json::json!({
            "uavs": uavs, "decisions": self.decisions, "late_decisions": self.late_decisions,
            "missed_decisions": self.missed_decisions, "setpoints": self.setpoints,
            "limited_setpoints": self.limited_setpoints, "limited_by": self.limits(), "messages_sent": self.sent,
            "messages_received": self.received, "messages_rejected": self.rejected,
        })
    }

    /// Adds another node's counts.
    pub fn add(&mut self, other: &Self) {
        self.decisions += other.decisions;
        self.late_decisions += other.late_decisions;
        self.missed_decisions += other.missed_decisions;
        self.setpoints += other.setpoints;
        self.limited_setpoints += other.limited_setpoints;
        self.limited.iter_mut().zip(other.limited).for_each(|(sum, count)| *sum += count);
        self.sent += other.sent;
        self.received += other.received;
        for (reason, count) in &other.rejected {
            *self.rejected.entry(reason).or_default() += count;
        }
    }
}

/// The name of a table's answer in summaries: the variant's in snake case.
const fn answer_name(answer: MessageOutcome) -> &'static str {
    match answer {
        MessageOutcome::New => "new",
        MessageOutcome::Replaced(_) => "replaced",
        MessageOutcome::Updated => "updated",
        MessageOutcome::Confirmed => "confirmed",
        MessageOutcome::Suspicious => "suspicious",
        MessageOutcome::OwnId => "own_id",
        MessageOutcome::Repeated => "repeated",
        MessageOutcome::Older => "older",
        MessageOutcome::Late => "late",
        MessageOutcome::Ahead => "ahead",
        MessageOutcome::TooFar => "too_far",
        MessageOutcome::UnknownSender => "unknown_sender",
        MessageOutcome::ForeignActor => "foreign_actor",
        MessageOutcome::WrongWidth => "wrong_width",
    }
}
