//! Drives the flight of a world: bring-up, the common epoch, the steps, the end.

use super::coverage::true_share;
use super::error::SimulationError;
use super::fleet::Fleet;
use super::settings::Simulation;
use super::world_flight::WorldFlight;
use crate::autopilot::Stage;
use crate::mission::Mission;
use crate::node::StepStart;
use crate::node::run::NodeEvent;
use crate::status_view::StatusView;
use covey_env::World;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// All UAVs must be in the air by then, simulated ms.
const BRING_UP_MS: i64 = 5 * 60_000;
/// From the moment when all are in the air to step 0, simulated ms.
const LEAD_TIME_MS: i64 = 10_000;
/// Before any node knows the time, its autopilot must have told it by then.
const SILENT: Duration = Duration::from_secs(120);
/// A flight in which no step starts for so long has failed.
const STALLED: Duration = Duration::from_secs(20);

/// Drives the flight of a world from the ground to its last step.
pub(super) struct FlightDriver<'s, 'a> {
    sim: &'s Simulation<'a>,
    world: &'s World,
    step_ms: i64,
    fleet: Fleet,
    events: &'s Receiver<(usize, NodeEvent)>,
    stop: &'s AtomicBool,
    epoch_ms: &'s AtomicI64,
    stages: Vec<Stage>,
    last_notices: Vec<String>,
    /// The vehicles' clock at the start, and the latest that a node told; Unix time, ms.
    start_ms: i64,
    clock_ms: i64,
    flight: WorldFlight,
    /// Steps begun by each UAV.
    begun: Vec<u32>,
    first_step: Option<Instant>,
    last_step: Instant,
    view: StatusView,
}

impl<'s, 'a> FlightDriver<'s, 'a> {
    #[expect(clippy::too_many_arguments, reason = "one place calls it, with all that the flight needs")]
    pub(super) fn new(
        sim: &'s Simulation<'a>,
        world: &'s World,
        mission: &Mission,
        fleet: Fleet,
        start_ms: i64,
        events: &'s Receiver<(usize, NodeEvent)>,
        stop: &'s AtomicBool,
        epoch_ms: &'s AtomicI64,
    ) -> Self {
        let (uavs, steps) = (sim.scenario.uavs, sim.scenario.steps as usize);
        Self {
            sim,
            world,
            step_ms: i64::from(mission.scale.step_ms),
            fleet,
            events,
            stop,
            epoch_ms,
            stages: vec![Stage::Silent; uavs],
            last_notices: vec![String::new(); uavs],
            start_ms,
            clock_ms: start_ms,
            flight: WorldFlight {
                states: vec![vec![None; uavs]; steps + 1],
                decisions: vec![vec![None; uavs]; steps],
                ..WorldFlight::default()
            },
            begun: vec![0; uavs],
            first_step: None,
            last_step: Instant::now(),
            view: StatusView::new(sim.view, String::new(), 0, uavs, &mission.pois),
        }
    }

    pub(super) fn drive(mut self) -> Result<WorldFlight, SimulationError> {
        let began = Instant::now();
        while self.stages.iter().any(|&stage| stage != Stage::Flying) {
            self.turn()?;
            if self.clock_ms == self.start_ms && began.elapsed() > SILENT {
                return Err(SimulationError::Silent { seconds: SILENT.as_secs(), who: self.missing() });
            }
            if self.clock_ms - self.start_ms > BRING_UP_MS || self.stages.contains(&Stage::Failed) {
                return Err(SimulationError::NotAirborne { minutes: BRING_UP_MS / 60_000, who: self.missing() });
            }
        }
        // A boundary of the fleet's own ticks, which divide a step.
        let epoch_ms =
            self.start_ms + (self.clock_ms - self.start_ms + LEAD_TIME_MS).div_euclid(self.step_ms) * self.step_ms;
        self.fleet.command(&json!({"epoch_unix_ms": epoch_ms}));
        self.epoch_ms.store(epoch_ms, Ordering::Relaxed);
        self.last_step = Instant::now();
        let steps = self.sim.scenario.steps;
        while self.begun.iter().any(|&begun| begun <= steps) {
            self.turn()?;
            if self.last_step.elapsed() > STALLED {
                let step = self.begun.iter().copied().min().unwrap_or(0);
                return Err(SimulationError::Stalled { seconds: STALLED.as_secs(), step, who: self.missing() });
            }
        }
        let first = self.first_step.unwrap_or(began);
        self.flight.wall_s = (self.last_step - first).as_secs_f64();
        self.flight.bring_up_s = (first - began).as_secs_f64();
        self.flight.simulated_s = f64::from(steps) * self.step_ms as f64 / 1000.0;
        for event in self.fleet.stop() {
            self.handle_fleet(&event);
        }
        self.view.clear();
        Ok(self.flight)
    }

    /// Handles the events of nodes and fleet.
    fn turn(&mut self) -> Result<(), SimulationError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(SimulationError::Stopped);
        }
        match self.events.recv_timeout(Duration::from_millis(20)) {
            Ok((id, event)) => self.handle_node(id, event)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(SimulationError::Stopped),
        }
        while let Ok((id, event)) = self.events.try_recv() {
            self.handle_node(id, event)?;
        }
        for event in self.fleet.events()? {
            self.handle_fleet(&event);
        }
        Ok(())
    }

    fn handle_node(&mut self, id: usize, event: NodeEvent) -> Result<(), SimulationError> {
        self.view.update(id, &event);
        match event {
            NodeEvent::Notice(notice) => {
                if self.sim.verbose || (notice.warning && self.first_step.is_some()) {
                    self.view.print(&format!("UAV {id}: {notice}"));
                }
                self.last_notices[id] = notice.text;
            }
            NodeEvent::Stage(stage) => self.stages[id] = stage,
            NodeEvent::Clock(common_ms) => self.clock_ms = self.clock_ms.max(common_ms),
            NodeEvent::StepStarted(step) => self.start_step(id, &step)?,
            NodeEvent::Decision(decision) => {
                if let Some(row) = self.flight.decisions.get_mut(decision.step as usize) {
                    row[id] = Some(decision);
                }
            }
            NodeEvent::Ended(counters) => self.flight.counters.add(&counters),
            NodeEvent::Status(_) => {}
        }
        Ok(())
    }

    fn start_step(&mut self, id: usize, step: &StepStart) -> Result<(), SimulationError> {
        if self.begun[id] == 0 && step.step != 0 {
            return Err(SimulationError::MissedStart(id));
        }
        self.begun[id] = step.step.saturating_add(1);
        self.last_step = Instant::now();
        self.first_step.get_or_insert(self.last_step);
        if let Some(row) = self.flight.states.get_mut(step.step as usize) {
            row[id] = Some(step.state);
        }
        Ok(())
    }

    fn handle_fleet(&mut self, event: &Value) {
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
                    self.view.print(&format!("fleet: {event}"));
                }
                self.flight.trouble.push(event.clone());
            }
            _ => {}
        }
    }

    /// The UAVs that are behind, with the last notice of each.
    fn missing(&self) -> String {
        let behind = |&id: &usize| {
            self.stages[id] != Stage::Flying
                || (self.first_step.is_some() && Some(&self.begun[id]) == self.begun.iter().min())
        };
        let one = |id: usize| format!("UAV {id} ({}; {})", self.stages[id].name(), self.last_notices[id]);
        (0..self.stages.len()).filter(behind).take(3).map(one).collect::<Vec<_>>().join(", ")
    }
}
