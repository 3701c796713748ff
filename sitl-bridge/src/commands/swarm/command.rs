//! The command `swarm`.

use super::real::RealArgs;
use super::shared::SharedArgs;
use super::simulated::SimulatedArgs;
use crate::commands::actor_file::flight_ready;
use crate::commands::console::stop_flag;
use crate::outlet::say;
use crate::simulation::FleetKind;
use crate::tlog::flight_folder;
use miette::{IntoDiagnostic as _, Result, WrapErr as _};

/// Arguments of `swarm`.
#[derive(clap::Args)]
pub(crate) struct Swarm {
    #[command(flatten)]
    shared: SharedArgs,
    /// Fly against autopilots that are started here, and compare with the trainer: simlink, Covey's own simulated
    /// ones, when left out; ArduPilot's Copter built for SITL; or PX4 from its build folder, in its built-in vehicle.
    #[arg(
        long,
        value_name = "arducopter=PROGRAM|px4=FOLDER",
        num_args = 0..=1,
        default_missing_value = "simlink"
    )]
    sim: Option<FleetKind>,
    #[command(flatten)]
    real: RealArgs,
    #[command(flatten)]
    simulated: SimulatedArgs,
}

impl Swarm {
    /// Flies until it is stopped or, simulated, until the last step.
    ///
    /// # Errors
    /// A file cannot be used or a link not be opened; the actor does not pass its self-test;
    /// the simulation fails.
    pub fn run(mut self) -> Result<()> {
        let stop = stop_flag()?;
        let (bytes, name) = self.shared.actor.read().into_diagnostic()?;
        let actor = flight_ready(&bytes, &name).into_diagnostic()?;
        if let Some(folder) = &mut self.shared.tlog {
            let unmade = || format!("no folder can be made for the recordings at {}", folder.display());
            let fresh = flight_folder(folder).into_diagnostic().wrap_err_with(unmade)?;
            if fresh != *folder {
                say(&format!(
                    "{} has recordings, which are kept: those of this flight go to {}",
                    folder.display(),
                    fresh.display()
                ));
            }
            *folder = fresh;
        }
        match self.sim {
            Some(autopilots) => self.simulated.simulate(autopilots, self.shared, actor, &stop),
            None => self.real.fly(&self.shared, actor, &stop),
        }
    }
}
