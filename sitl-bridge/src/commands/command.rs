//! The command line of `sitl-bridge`.

use super::actor_file::{SelfTest, Signature};
use super::fly::Fly;
use super::mission::MissionCommand;
use super::replay::ReplayTlog;
use super::swarm::Swarm;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Flies Covey's actor over MAVLink.
#[derive(Parser)]
#[command(name = "sitl-bridge", version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Fly one UAV.
    Fly(Box<Fly>),
    /// Fly several UAVs from this computer, real or simulated ones.
    Swarm(Box<Swarm>),
    /// Decide a recorded flight again, and report decisions that differ.
    Replay(ReplayTlog),
    /// Write the mission of a world of the scenario, check a mission, or make one of GeoJSON, KML, CSV, a plan or waypoints.
    Mission(Box<MissionCommand>),
    /// Test an actor file on this computer, as is done before each flight.
    SelfTest(SelfTest),
    /// Print an actor file's signature: the same number wherever the actor decides the same.
    Signature(Signature),
}

impl Cli {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong, in words for the user.
    pub fn run(self) -> miette::Result<ExitCode> {
        match self.command {
            Command::Replay(args) => return Ok(args.run()),
            Command::Fly(args) => args.run(),
            Command::Swarm(args) => args.run(),
            Command::Mission(args) => args.run(),
            Command::SelfTest(args) => args.run(),
            Command::Signature(args) => args.run(),
        }?;
        Ok(ExitCode::SUCCESS)
    }
}
