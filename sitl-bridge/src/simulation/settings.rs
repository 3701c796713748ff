//! Settings of a simulation.

use super::fleet::find_python;
use super::fleet_kind::FleetKind;
use crate::mission::{Layers, Mission, Origin, OriginError, square_fence};
use crate::node::StepTiming;
use crate::signing::LinkSigning;
use crate::status_view::ViewMode;
use covey_env::{Scenario, World, policy_seed};
use firmware_core::actor::{Actor, Mode};
use std::path::PathBuf;

/// The fleet's clock begins here, so that every run is the same: 2026-11-22, Unix time in ms.
pub(super) const START_UNIX_MS: i64 = 1_795_305_600_000;
/// A fence that no action of the scenario reaches, u.
const IDEAL_MARGIN_U: f64 = 100.0;

/// The settings of a simulation; [`Simulation::run`] runs it.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    /// The actor, which has passed its self-test.
    pub actor: Actor<'a>,
    /// The worlds' scenario.
    pub scenario: Scenario,
    /// Seed of the worlds.
    pub seed: u64,
    /// Whether actions are sampled or the most likely ones.
    pub mode: Mode,
    /// The autopilots.
    pub autopilots: FleetKind,
    /// Vehicles have the scenario's own dynamics instead of those of a point mass with lag and drag.
    pub ideal: bool,
    /// Simulated autopilots are PX4 instead of ArduPilot.
    pub px4: bool,
    /// So many times real time, by the host's clock; when left out, simlink runs in lock-step and real firmware
    /// in real time.
    pub speed: Option<f64>,
    /// The phases of a step.
    pub timing: StepTiming,
    /// Rate of positions from the autopilots, Hz.
    pub rate_hz: u16,
    /// Python interpreter of the fleet.
    pub python: PathBuf,
    /// Signing of the autopilots' links and of the swarm's link.
    pub signing: (LinkSigning, LinkSigning),
    /// File with the key of `signing`, for the fleet.
    pub key_file: Option<PathBuf>,
    /// Fields that replace those of the fleet's configuration: faults, wind, clocks.
    pub fleet: serde_json::Map<String, serde_json::Value>,
    /// First sequence number of neighbour messages; by the clock when left out.
    pub sequence: Option<u16>,
    /// Folder for the recordings of the nodes, `world-W-uav-I.tlog`, and the missions of the worlds,
    /// `world-W.toml`.
    pub tlogs: Option<PathBuf>,
    /// How the status is shown during the flights.
    pub view: ViewMode,
    /// Print all notices and events.
    pub verbose: bool,
}

impl<'a> Simulation<'a> {
    /// Worlds of seed 777 of this scenario, flown with simulated ArduPilots in lock-step, with sampled
    /// actions as in training, unsigned. `actor` must have passed its self-test.
    #[must_use]
    pub fn new(actor: Actor<'a>, scenario: Scenario) -> Self {
        Self {
            actor,
            scenario,
            seed: 777,
            mode: Mode::Sample,
            autopilots: FleetKind::Simlink,
            ideal: false,
            px4: false,
            speed: None,
            timing: StepTiming::default(),
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

    /// The mission of world `index`.
    ///
    /// # Errors
    /// When no map can be laid at the origin.
    pub fn mission(&self, world: &World, index: u64) -> Result<Mission, OriginError> {
        let mut mission = Mission::of_world(world, Origin::default())?;
        mission.policy_seed = policy_seed(self.seed, index);
        mission.mode = self.mode;
        // Close together, so that takeoff takes no time: simulated vehicles do not collide.
        let count = u16::try_from(world.x().len()).unwrap_or(u16::MAX);
        mission.layers = Layers { base_m: 10.0, spacing_m: (100.0 / f64::from(count)).min(1.0), count };
        if self.ideal {
            mission.fence = square_fence(mission.side_u, IDEAL_MARGIN_U);
        }
        Ok(mission)
    }
}
