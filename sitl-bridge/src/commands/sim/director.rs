//! Leads a flight: from the ground over the wait for everybody to the last step.

use super::account::true_share;
use super::fleet::Fleet;
use super::flight::START_UNIX_MS;
use super::{SimError, Simulation, WorldFlight};
use crate::autopilot::Stage;
use crate::commands::view::View;
use crate::mission::Mission;
use crate::node::StepBegun;
use crate::node::run::Report;
use covey_env::World;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Everybody is in the air by then, simulated ms.
const BRING_UP_MS: i64 = 5 * 60_000;
/// From the moment when all are in the air to step 0, simulated ms.
const LEAD_MS: i64 = 10_000;
/// A flight that stands still for so long has failed.
const STALLED: Duration = Duration::from_secs(20);

/// Leads a flight from the ground to its last step.
pub(super) struct Director<'s, 'a> {
    sim: &'s Simulation<'a>,
    world: &'s World,
    step_ms: i64,
    fleet: Fleet,
    reports: &'s Receiver<(usize, Report)>,
    stop: &'s AtomicBool,
    epoch_ms: &'s AtomicI64,
    stages: Vec<Stage>,
    words: Vec<String>,
    clock_ms: i64,
    flight: WorldFlight,
    /// Steps begun by each UAV.
    begun: Vec<u32>,
    first_step: Option<Instant>,
    last_step: Instant,
    view: View,
}

impl<'s, 'a> Director<'s, 'a> {
    pub(super) fn new(
        sim: &'s Simulation<'a>,
        world: &'s World,
        mission: &Mission,
        fleet: Fleet,
        reports: &'s Receiver<(usize, Report)>,
        stop: &'s AtomicBool,
        epoch_ms: &'s AtomicI64,
    ) -> Self {
        let (uavs, steps) = (sim.scenario.uavs, sim.scenario.steps as usize);
        Self {
            sim,
            world,
            step_ms: i64::from(mission.scale.step_ms),
            fleet,
            reports,
            stop,
            epoch_ms,
            stages: vec![Stage::Silent; uavs],
            words: vec![String::new(); uavs],
            clock_ms: START_UNIX_MS,
            flight: WorldFlight {
                states: vec![vec![None; uavs]; steps + 1],
                decisions: vec![vec![None; uavs]; steps],
                ..WorldFlight::default()
            },
            begun: vec![0; uavs],
            first_step: None,
            last_step: Instant::now(),
            view: View::new(sim.view, String::new(), 0, uavs, &mission.pois),
        }
    }

    pub(super) fn direct(mut self) -> Result<WorldFlight, SimError> {
        let began = Instant::now();
        while self.stages.iter().any(|&stage| stage != Stage::Flying) {
            self.turn()?;
            if self.clock_ms - START_UNIX_MS > BRING_UP_MS || self.stages.contains(&Stage::Failed) {
                return Err(SimError::NotAirborne { minutes: BRING_UP_MS / 60_000, who: self.missing() });
            }
        }
        // On a boundary of the fleet's own ticks, which divide a step.
        let epoch_ms =
            START_UNIX_MS + (self.clock_ms - START_UNIX_MS + LEAD_MS).div_euclid(self.step_ms) * self.step_ms;
        self.fleet.command(&json!({"epoch_unix_ms": epoch_ms}));
        self.epoch_ms.store(epoch_ms, Ordering::Relaxed);
        self.last_step = Instant::now();
        let steps = self.sim.scenario.steps;
        while self.begun.iter().any(|&begun| begun <= steps) {
            self.turn()?;
            if self.last_step.elapsed() > STALLED {
                let step = self.begun.iter().copied().min().unwrap_or(0);
                return Err(SimError::Stalled { seconds: STALLED.as_secs(), step, who: self.missing() });
            }
        }
        let first = self.first_step.unwrap_or(began);
        self.flight.wall_s = (self.last_step - first).as_secs_f64();
        self.flight.bring_up_s = (first - began).as_secs_f64();
        self.flight.simulated_s = f64::from(steps) * self.step_ms as f64 / 1000.0;
        for event in self.fleet.stop() {
            self.hear(&event);
        }
        self.view.clear();
        Ok(self.flight)
    }

    /// Takes in what nodes and fleet tell.
    fn turn(&mut self) -> Result<(), SimError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(SimError::Stopped);
        }
        match self.reports.recv_timeout(Duration::from_millis(20)) {
            Ok((id, report)) => self.take(id, report)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(SimError::Stopped),
        }
        while let Ok((id, report)) = self.reports.try_recv() {
            self.take(id, report)?;
        }
        for event in self.fleet.events()? {
            self.hear(&event);
        }
        Ok(())
    }

    fn take(&mut self, id: usize, report: Report) -> Result<(), SimError> {
        self.view.hear(id, &report);
        match report {
            Report::Notice(notice) => {
                if self.sim.verbose || (notice.warning && self.first_step.is_some()) {
                    self.view.say(&format!("UAV {id}: {notice}"));
                }
                self.words[id] = notice.text;
            }
            Report::Stage(stage) => self.stages[id] = stage,
            Report::Clock(common_ms) => self.clock_ms = self.clock_ms.max(common_ms),
            Report::Begun(begun) => self.begin(id, &begun)?,
            Report::Decision(decision) => {
                if let Some(row) = self.flight.decisions.get_mut(decision.step as usize) {
                    row[id] = Some(decision);
                }
            }
            Report::Ended(counters) => self.flight.counters.add(&counters),
            Report::Status(_) => {}
        }
        Ok(())
    }

    fn begin(&mut self, id: usize, begun: &StepBegun) -> Result<(), SimError> {
        if self.begun[id] == 0 && begun.step != 0 {
            return Err(SimError::MissedStart(id));
        }
        self.begun[id] = begun.step.saturating_add(1);
        self.last_step = Instant::now();
        self.first_step.get_or_insert(self.last_step);
        if let Some(row) = self.flight.states.get_mut(begun.step as usize) {
            row[id] = Some(begun.state);
        }
        Ok(())
    }

    fn hear(&mut self, event: &Value) {
        match event["event"].as_str() {
            Some("truth") => {
                let steps = self.sim.scenario.steps as usize;
                let step = event["step"].as_u64().unwrap_or(0) as usize;
                if (1..=steps).contains(&step)
                    && let Some(share) = true_share(self.world, &event["u"])
                {
                    self.flight.true_coverage.push(share);
                }
            }
            Some("timeout" | "failsafe" | "crash" | "lockstep_timeout" | "error") => {
                if self.sim.verbose {
                    self.view.say(&format!("fleet: {event}"));
                }
                self.flight.trouble.push(event.clone());
            }
            _ => {}
        }
    }

    /// Who is behind, and what each said last.
    fn missing(&self) -> String {
        let behind = |&id: &usize| {
            self.stages[id] != Stage::Flying
                || (self.first_step.is_some() && Some(&self.begun[id]) == self.begun.iter().min())
        };
        let one = |id: usize| format!("UAV {id} ({}; {})", self.stages[id].name(), self.words[id]);
        (0..self.stages.len()).filter(behind).take(3).map(one).collect::<Vec<_>>().join(", ")
    }
}
