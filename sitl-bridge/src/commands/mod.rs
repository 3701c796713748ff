//! The command line.

mod actor_file;
mod common;
mod fly;
mod mission;
mod recorded;
mod replay;
mod sim;
mod swarm;
mod view;

pub use actor_file::ActorFileError;
pub use sim::{Fleet, FleetError, Page, PageError, SimError, Simulation, WorldFlight, find_python};

pub use view::{Size, View, ViewMode};

use clap::Parser;
use miette::IntoDiagnostic as _;
use std::process::ExitCode;

/// Flies Covey's actor over MAVLink.
#[derive(Parser)]
#[command(name = "sitl-bridge", version)]
pub enum Command {
    /// Fly one UAV.
    Fly(Box<fly::Fly>),
    /// Fly several UAVs from this computer, real or simulated ones.
    Swarm(Box<swarm::Swarm>),
    /// Decide a recorded flight again, and report decisions that differ.
    Replay(replay::ReplayTlog),
    /// Write the mission of a world of the scenario, check a mission, or make one of GeoJSON, KML, CSV, a plan or waypoints.
    Mission(Box<mission::MissionCommand>),
    /// Test an actor file on this computer, as is done before each flight.
    SelfTest(actor_file::SelfTest),
    /// Print an actor file's signature: the same number wherever the actor decides the same.
    Signature(actor_file::Signature),
}

impl Command {
    /// Carries it out.
    ///
    /// # Errors
    /// What went wrong, for a person.
    pub fn run(self) -> miette::Result<ExitCode> {
        match self {
            Self::Replay(args) => return Ok(args.run()),
            Self::Fly(args) => args.run(),
            Self::Swarm(args) => args.run(),
            Self::Mission(args) => args.run(),
            Self::SelfTest(args) => args.run().into_diagnostic(),
            Self::Signature(args) => args.run().into_diagnostic(),
        }?;
        Ok(ExitCode::SUCCESS)
    }
}
