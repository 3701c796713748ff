//! Counts of what happened in a flight.

use firmware_core::gate::Limited;
use firmware_core::neighbour_table::MessageOutcome;
use std::collections::BTreeMap;

/// Counts of a flight.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Decisions made.
    pub decisions: u64,
    /// Sum of the times from a step's start to its decision, ms; see [`super::Decision::phase_ms`].
    pub decision_ms: u64,
    /// Decisions that were late; see [`super::Decision::late`].
    pub late_decisions: u64,
    /// Steps in the air that ended without a decision.
    pub missed_decisions: u64,
    /// Setpoints sent.
    pub setpoints: u64,
    /// Setpoints that the safety gate limited.
    pub limited_setpoints: u64,
    /// Setpoints by what the gate limited: speed, acceleration, fence, altitude.
    pub limited: [u64; 4],
    /// Neighbour messages sent.
    pub sent: u64,
    /// Neighbour messages that the neighbour table took.
    pub received: u64,
    /// What was received and not used, by reason: of the links and of the neighbour table.
    pub rejected: BTreeMap<&'static str, u64>,
}

impl Counters {
    /// Counts a sent setpoint.
    pub(super) fn count_setpoint(&mut self, limited: Limited) {
        self.setpoints += 1;
        self.limited_setpoints += u64::from(limited.any());
        let kinds = [limited.speed, limited.acceleration, limited.fence, limited.altitude];
        self.limited.iter_mut().zip(kinds).for_each(|(count, changed)| *count += u64::from(changed));
    }

    /// Setpoints by what the gate limited, with names.
    #[must_use]
    pub fn limits(&self) -> BTreeMap<&'static str, u64> {
        ["speed", "acceleration", "fence", "altitude"].into_iter().zip(self.limited).collect()
    }

    /// Counts a neighbour message by the neighbour table's outcome.
    pub(super) fn count_message(&mut self, outcome: MessageOutcome) {
        if outcome.is_taken() {
            self.received += 1;
        } else {
            *self.rejected.entry(outcome_name(outcome)).or_default() += 1;
        }
    }

    /// Mean time from a step's start to its decision, ms; 0 without decisions.
    #[must_use]
    pub fn decision_ms_mean(&self) -> f64 {
        self.decision_ms as f64 / self.decisions.max(1) as f64
    }

    /// One JSON object with the names that the summary of a simulated swarm uses.
    #[must_use]
    pub fn to_json(&self, uavs: u16) -> serde_json::Value {
        serde_json::json!({
            "uavs": uavs, "decisions": self.decisions, "decision_ms_mean": self.decision_ms_mean(), "late_decisions": self.late_decisions,
            "missed_decisions": self.missed_decisions, "setpoints": self.setpoints,
            "limited_setpoints": self.limited_setpoints, "limited_by": self.limits(), "messages_sent": self.sent,
            "messages_received": self.received, "messages_rejected": self.rejected,
        })
    }

    /// Adds another node's counts.
    pub fn add(&mut self, other: &Self) {
        self.decisions += other.decisions;
        self.decision_ms += other.decision_ms;
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

/// The name of a table's outcome in summaries: the variant's in snake case.
const fn outcome_name(outcome: MessageOutcome) -> &'static str {
    match outcome {
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
