//! `swarm --sim`: nodes against a fleet of simulated autopilots, world after world, measured
//! against the trainer's evaluation of the same worlds.

mod account;
mod director;
mod fleet;
mod flight;
mod page;
mod trainer;

pub use fleet::{Fleet, FleetError, find_python};
pub use flight::WorldFlight;
pub use page::{Page, PageError};

use super::view::ViewMode;
use crate::connection::OpenError;
use crate::mission::{Layers, Mission, Origin, OriginError, square_fence};
use crate::node::{SettingsError, Timing};
use crate::signing::LinkSigning;
use crate::summary::Summary;
use covey_env::{Scenario, ScenarioError, World, policy_seed};
use firmware_core::actor::{Actor, Mode};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// A fence that no action of the scenario reaches, u.
const IDEAL_MARGIN_U: f64 = 100.0;

/// From the ground into the air the fleet moves at this many times real time …
const BRING_UP_SPEED: f64 = 20.0;
/// … or at this, on a busy computer.
const SLOW_BRING_UP_SPEED: f64 = 4.0;

/// Why a simulation ended early.
#[derive(Debug, Error)]
pub enum SimError {
    /// The scenario cannot be.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The map cannot be laid.
    #[error(transparent)]
    Origin(#[from] OriginError),
    /// A socket cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A node cannot be made.
    #[error(transparent)]
    Node(#[from] SettingsError),
    /// No fleet, or it ended.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// A node's thread ended.
    #[error("the node of UAV {id} ended: {source}")]
    Thread {
        /// Which one.
        id: usize,
        /// Why.
        source: io::Error,
    },
    /// Not everybody got into the air.
    #[error("not everybody is in the air after {minutes} simulated minutes: {who}")]
    NotAirborne {
        /// How long it was waited for.
        minutes: i64,
        /// Who is missing, and the last that each said.
        who: String,
    },
    /// The flight stands still.
    #[error("nothing happened for {seconds} s in step {step}: {who}")]
    Stalled {
        /// How long it was waited for.
        seconds: u64,
        /// The step that the slowest is in.
        step: u32,
        /// Who is behind.
        who: String,
    },
    /// Somebody began late.
    #[error("UAV {0} missed the beginning of step 0; is the computer overloaded?")]
    MissedStart(usize),
    /// The mission could not be put beside the recordings.
    #[error(transparent)]
    Write(#[from] covey_report::atomic::WriteError),
    /// It was stopped from outside.
    #[error("stopped")]
    Stopped,
}

/// A simulation to be run.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    /// The actor, which has passed its self-test.
    pub actor: Actor<'a>,
    /// The worlds' scenario.
    pub scenario: Scenario,
    /// Their seed.
    pub seed: u64,
    /// How actions are drawn.
    pub mode: Mode,
    /// The scenario's own dynamics instead of a point mass's.
    pub ideal: bool,
    /// Vehicles are PX4 instead of ArduPilot.
    pub px4: bool,
    /// Wall clock instead of lock-step: so many times real time.
    pub speed: Option<f64>,
    /// When things happen in a step.
    pub timing: Timing,
    /// Telemetry, Hz.
    pub rate_hz: u16,
    /// The fleet's interpreter.
    pub python: PathBuf,
    /// Keys of the autopilots' and the swarm's links, and the file for the fleet.
    pub signing: (LinkSigning, LinkSigning),
    /// See `signing`.
    pub key_file: Option<PathBuf>,
    /// Set over the fleet's configuration, for tests: faults, wind, clocks.
    pub fleet: serde_json::Map<String, serde_json::Value>,
    /// First sequence number of neighbour messages; by the clock when left out.
    pub sequence: Option<u16>,
    /// Where nodes record their traffic: `world-W-uav-I.tlog` in this folder, beside the world's
    /// mission, `world-W.toml`.
    pub tlogs: Option<PathBuf>,
    /// How the flights are shown while they last.
    pub view: ViewMode,
    /// Tell everything.
    pub verbose: bool,
}

impl<'a> Simulation<'a> {
    /// Worlds of seed 777 of this scenario, flown by simulated ArduPilots in lock-step, as trained:
    /// with drawn actions, unsigned. `actor` must have passed its self-test.
    #[must_use]
    pub fn new(actor: Actor<'a>, scenario: Scenario) -> Self {
        Self {
            actor,
            scenario,
            seed: 777,
            mode: Mode::Sample,
            ideal: false,
            px4: false,
            speed: None,
            timing: Timing::default(),
            rate_hz: 5,
            python: find_python(None),
            signing: (LinkSigning::off(), LinkSigning::off()),
            key_file: None,
            fleet: serde_json::Map::new(),
            sequence: None,
            tlogs: None,
            view: ViewMode::Off,
            verbose: false,
        }
    }

    /// Flies the worlds of these indices one after the other and hands each to `done`. `stop` ends
    /// it early.
    ///
    /// # Errors
    /// See [`SimError`].
    pub fn run(
        &self,
        worlds: std::ops::Range<u64>,
        stop: &Arc<AtomicBool>,
        mut done: impl FnMut(u64, &WorldFlight),
    ) -> Result<Summary, SimError> {
        let mut summary = Summary::new(self.scenario.uavs, self.scenario.steps);
        for index in worlds {
            let flight = self.fly(index, stop)?;
            summary.add(&flight);
            done(index, &flight);
        }
        Ok(summary)
    }

    /// Flies one world.
    ///
    /// # Errors
    /// See [`SimError`].
    pub fn fly(&self, index: u64, stop: &Arc<AtomicBool>) -> Result<WorldFlight, SimError> {
        let mut world = World::new(&self.scenario)?;
        world.reset(self.seed, index);
        // The second try is for a computer so busy that autopilots missed their heartbeats.
        match flight::fly(self, index, &world, BRING_UP_SPEED, stop) {
            Err(error @ (SimError::NotAirborne { .. } | SimError::MissedStart(_))) if self.fleet.is_empty() => {
                eprintln!("world {index}: {error}; once more, slower");
                flight::fly(self, index, &world, SLOW_BRING_UP_SPEED, stop)
            }
            flown => flown,
        }
    }

    /// The mission of world `index`.
    ///
    /// # Errors
    /// When no map can be laid at the origin.
    pub fn mission(&self, world: &World, index: u64) -> Result<Mission, OriginError> {
        let mut mission = Mission::of_world(world, Origin::default())?;
        mission.policy_seed = policy_seed(self.seed, index);
        mission.mode = self.mode;
        // Close together, so that takeoff takes no time: simulated vehicles do not collide.
        mission.layers = Layers { base_m: 10.0, spacing_m: 1.0, count: 10 };
        if self.ideal {
            mission.fence = square_fence(mission.side_u, IDEAL_MARGIN_U);
        }
        Ok(mission)
    }
}
