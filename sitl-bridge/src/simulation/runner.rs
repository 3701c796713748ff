//! Runs a simulation, world after world.

use super::error::SimulationError;
use super::fleet_kind::FleetKind;
use super::flight::{fly_world, set_recordings_aside};
use super::settings::Simulation;
use super::summary::Summary;
use super::world_flight::WorldFlight;
use crate::outlet::say;
use covey_env::World;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// From the ground into the air the fleet runs at this many times real time …
const BRING_UP_SPEED: f64 = 20.0;
/// … or at this, on a busy computer.
const SLOW_BRING_UP_SPEED: f64 = 4.0;

impl Simulation<'_> {
    /// Flies the worlds of these indices one after the other and hands each to `done`. `stop` ends
    /// it early.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn run(
        &self,
        worlds: std::ops::Range<u64>,
        stop: &Arc<AtomicBool>,
        mut done: impl FnMut(u64, &WorldFlight),
    ) -> Result<Summary, SimulationError> {
        let mut summary = Summary::new(&self.autopilots, self.scenario.uavs, self.scenario.steps);
        for index in worlds {
            let mut flight = self.fly(index, stop)?;
            if self.autopilots.is_real() {
                flight.simlink_coverage = Some(self.on_simlink().fly(index, stop)?.coverage);
            }
            summary.add(&flight);
            done(index, &flight);
        }
        Ok(summary)
    }

    /// The same simulation on simlink, which real autopilots are held against; nothing of it is recorded.
    fn on_simlink(&self) -> Self {
        Self { autopilots: FleetKind::Simlink, speed: None, tlogs: None, ..self.clone() }
    }

    /// Flies one world.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn fly(&self, index: u64, stop: &Arc<AtomicBool>) -> Result<WorldFlight, SimulationError> {
        let mut world = World::new(&self.scenario)?;
        world.reset(self.seed, index);
        // The second try is for a computer so busy that autopilots missed their heartbeats.
        match fly_world(self, index, &world, BRING_UP_SPEED, stop) {
            Err(error @ (SimulationError::NotAirborne { .. } | SimulationError::MissedStart(_)))
                if self.fleet.is_empty() =>
            {
                say(&format!("world {index}: {error}; once more, slower"));
                set_recordings_aside(self, index)?;
                fly_world(self, index, &world, SLOW_BRING_UP_SPEED, stop)
            }
            flown => flown,
        }
    }
}
