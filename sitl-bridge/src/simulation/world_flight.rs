//! The record of one world's flight.

use crate::node::{Counters, Decision};
use covey_env::EpisodeMetrics;
use firmware_core::geometry::State;
use serde_json::Value;

/// The flight of one world, and its comparison with the trainer's evaluation.
#[derive(Clone, Debug, Default)]
pub struct WorldFlight {
    /// States of all UAVs at the beginning of each step, 0 to the last and one beyond it; `None`
    /// where a UAV's telemetry missed the step.
    pub states: Vec<Vec<Option<State>>>,
    /// Decisions by step and UAV.
    pub decisions: Vec<Vec<Option<Decision>>>,
    /// Share of PoIs covered after each step, by the nodes' telemetry.
    pub coverage: Vec<f64>,
    /// The same, by the true positions of the simulated vehicles.
    pub true_coverage: Vec<f64>,
    /// The same, flown on simlink, where real autopilots flew.
    pub simlink_coverage: Option<Vec<f64>>,
    /// The same in the trainer's flight.
    pub trainer_coverage: Vec<f64>,
    /// Metrics of the trainer's flight.
    pub trainer: EpisodeMetrics,
    /// Decisions equal to the trainer's: with ideal dynamics those of its own flight of the world,
    /// else those that it makes in the situations that were measured.
    pub equal: u64,
    /// Decisions that could be compared.
    pub compared: u64,
    /// The first decision that differs from the trainer's, in words.
    pub first_difference: Option<String>,
    /// Counts of all nodes; decisions are those of the flight's steps.
    pub counters: Counters,
    /// Simulated time of the steps, s.
    pub simulated_s: f64,
    /// Host's time of the steps, s.
    pub wall_s: f64,
    /// Host's time before the first step, s.
    pub bring_up_s: f64,
    /// The fleet's events of time-outs, failsafes, crashes and errors.
    pub trouble: Vec<Value>,
}

impl WorldFlight {
    /// Counts the decisions of the flight's steps. Some nodes begin the step after the last and decide in
    /// it, others are ended before.
    pub(super) fn count_decisions(&mut self) {
        let decisions = || self.decisions.iter().flatten().flatten();
        self.counters.decisions = decisions().count() as u64;
        self.counters.late_decisions = decisions().filter(|decision| decision.late).count() as u64;
        self.counters.decision_ms = decisions().map(|decision| u64::from(decision.phase_ms)).sum();
    }
}
