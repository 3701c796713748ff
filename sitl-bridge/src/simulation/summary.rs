//! The summary of a simulation.

use super::fleet_kind::FleetKind;
use super::world_flight::WorldFlight;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The summary of a simulation: what `swarm --sim --json` ends with.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// The autopilots: simlink, arducopter or px4.
    pub autopilots: &'static str,
    /// UAVs in each world.
    pub uavs: usize,
    /// Worlds flown.
    pub worlds: u64,
    /// Steps in each world.
    pub steps: u32,
    /// Mean over worlds and steps of the share of PoIs covered, by the nodes' telemetry.
    pub coverage_mean: f64,
    /// The same, by the true positions of the simulated vehicles.
    pub true_coverage_mean: f64,
    /// The same worlds flown on simlink, beside real autopilots.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simlink_coverage_mean: Option<f64>,
    /// Coverage flown over the trainer's, and its standard error over worlds, in pairs; without one of a single world.
    pub share_of_trainer: f64,
    /// See [`Summary::share_of_trainer`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_standard_error: Option<f64>,
    /// The same, of the trainer's int8 evaluation of the same worlds.
    pub trainer_coverage_mean: f64,
    /// Simulated time over the host's, from the first step to the last.
    pub realtime_factor: f64,
    /// The same with takeoff and the fleet's start.
    pub realtime_factor_overall: f64,
    /// Decisions made.
    pub decisions: u64,
    /// Mean time from a step's start to its decision, ms.
    pub decision_ms_mean: f64,
    /// Decisions equal to the trainer's; see `docs/bridge.md`.
    pub decisions_equal_to_trainer: u64,
    /// Decisions that could be compared.
    pub decisions_compared: u64,
    /// Decisions that were late.
    pub late_decisions: u64,
    /// Steps without a decision.
    pub missed_decisions: u64,
    /// Setpoints sent.
    pub setpoints: u64,
    /// Setpoints that the safety gate limited.
    pub limited_setpoints: u64,
    /// Setpoints by what the gate limited.
    pub limited_by: BTreeMap<&'static str, u64>,
    /// Neighbour messages sent.
    pub messages_sent: u64,
    /// Neighbour messages that the neighbour tables took.
    pub messages_received: u64,
    /// What was received and not used, by reason.
    pub messages_rejected: BTreeMap<&'static str, u64>,
    /// The fleet's events of time-outs, failsafes, crashes and errors.
    pub fleet_troubles: u64,
    /// Coverage flown less the trainer's, world by world.
    #[serde(skip)]
    differences: Vec<f64>,
    #[serde(skip)]
    simulated_s: f64,
    #[serde(skip)]
    wall_s: f64,
    #[serde(skip)]
    bring_up_s: f64,
}

impl Summary {
    /// A summary without worlds.
    #[must_use]
    pub fn new(autopilots: &FleetKind, uavs: usize, steps: u32) -> Self {
        Self { autopilots: autopilots.name(), uavs, steps, ..Self::default() }
    }

    /// Adds a world.
    pub fn add(&mut self, flight: &WorldFlight) {
        let mean = |sum: &mut f64, value: f64, worlds: u64| *sum += (value - *sum) / worlds as f64;
        let average = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        self.worlds += 1;
        mean(&mut self.coverage_mean, average(&flight.coverage), self.worlds);
        mean(&mut self.true_coverage_mean, average(&flight.true_coverage), self.worlds);
        mean(&mut self.trainer_coverage_mean, average(&flight.trainer_coverage), self.worlds);
        if let Some(simlink) = &flight.simlink_coverage {
            mean(self.simlink_coverage_mean.get_or_insert_default(), average(simlink), self.worlds);
        }
        self.differences.push(average(&flight.coverage) - average(&flight.trainer_coverage));
        self.share_of_trainer = self.coverage_mean / self.trainer_coverage_mean.max(1e-9);
        self.share_standard_error =
            standard_error(&self.differences).map(|error| error / self.trainer_coverage_mean.max(1e-9));
        self.simulated_s += flight.simulated_s;
        self.wall_s += flight.wall_s;
        self.bring_up_s += flight.bring_up_s;
        self.realtime_factor = self.simulated_s / self.wall_s.max(1e-9);
        self.realtime_factor_overall = self.simulated_s / (self.wall_s + self.bring_up_s).max(1e-9);
        let counters = &flight.counters;
        let decisions = self.decisions + counters.decisions;
        let decision_ms = self.decision_ms_mean * self.decisions as f64 + counters.decision_ms as f64;
        (self.decisions, self.decision_ms_mean) = (decisions, decision_ms / decisions.max(1) as f64);
        self.decisions_equal_to_trainer += flight.equal;
        self.decisions_compared += flight.compared;
        self.late_decisions += counters.late_decisions;
        self.missed_decisions += counters.missed_decisions;
        self.setpoints += counters.setpoints;
        self.limited_setpoints += counters.limited_setpoints;
        for (limit, count) in counters.limits() {
            *self.limited_by.entry(limit).or_default() += count;
        }
        self.messages_sent += counters.sent;
        self.messages_received += counters.received;
        for (reason, count) in &counters.rejected {
            *self.messages_rejected.entry(reason).or_default() += count;
        }
        self.fleet_troubles += flight.trouble.len() as u64;
    }
}

/// The standard error of the mean; `None` of fewer than two values.
fn standard_error(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt())
}

/// For people.
impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { uavs, worlds, steps, .. } = self;
        writeln!(f, "{uavs} UAVs on {}, {worlds} worlds of {steps} steps", self.autopilots)?;
        let error = self.share_standard_error.map_or_else(String::new, |error| format!(" ±{:.1}", 100.0 * error));
        writeln!(
            f,
            "coverage       {:.4}; the trainer's int8 evaluation {:.4} ({:.1}{error} %)",
            self.coverage_mean,
            self.trainer_coverage_mean,
            100.0 * self.share_of_trainer
        )?;
        if let Some(simlink) = self.simlink_coverage_mean {
            let share = 100.0 * simlink / self.trainer_coverage_mean.max(1e-9);
            writeln!(f, "on simlink     {simlink:.4} ({share:.1} %); true positions {:.4}", self.true_coverage_mean)?;
        }
        writeln!(f, "real time      x {:.1} ({:.1} with takeoff)", self.realtime_factor, self.realtime_factor_overall)?;
        writeln!(
            f,
            "decisions      {}, {:.0} ms after the step's start, {} late, {} missed; {} of {} as the trainer's",
            self.decisions,
            self.decision_ms_mean,
            self.late_decisions,
            self.missed_decisions,
            self.decisions_equal_to_trainer,
            self.decisions_compared
        )?;
        writeln!(f, "setpoints      {}, {} changed by the gate", self.setpoints, self.limited_setpoints)?;
        write!(f, "messages       {} sent, {} taken", self.messages_sent, self.messages_received)?;
        self.messages_rejected.iter().try_for_each(|(reason, count)| write!(f, ", {count} {reason}"))
    }
}
