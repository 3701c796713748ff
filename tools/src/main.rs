//! `cargo xtask`: the commands that set up, test, build for targets, measure and flash Covey.

mod command;
mod counts;
mod document;
mod error;
mod figures;
mod flash;
mod modules;
mod output;
mod setup;
mod sitl;
mod size;
mod targets;
mod test;
mod workspace;

use std::process::ExitCode;

use clap::Parser;
use output::tell;

/// Sets up, tests, builds for targets, measures and flashes Covey.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
enum Xtask {
    /// Install what the tests and the target builds need (Debian and its kin).
    Setup(setup::Args),
    /// Build for every target, run it in emulators, measure it and check the figures.
    Targets(targets::Args),
    /// Count the instructions of the trainer's parts under valgrind and check the counts.
    Counts(counts::Args),
    /// Print flash, RAM and instructions of an actor file on a flight controller, and whether it fits.
    Size(size::Args),
    /// Put the program and an actor file on a board, or the node and the file on a computer.
    Flash(flash::Args),
    /// Check that no source files depend on each other in a circle, and the dependencies between the crates.
    Modules(modules::Args),
    /// Fly the node beside real autopilot firmware, of a build of yours, and print how each case went.
    Sitl(sitl::Args),
    /// Run every check and test, after installing what they need.
    Test(test::Args),
}

fn main() -> ExitCode {
    let done = match Xtask::parse() {
        Xtask::Setup(args) => setup::main(&args),
        Xtask::Targets(args) => targets::main(&args),
        Xtask::Counts(args) => counts::main(&args),
        Xtask::Size(args) => size::main(&args),
        Xtask::Flash(args) => flash::main(&args),
        Xtask::Modules(args) => modules::main(&args),
        Xtask::Sitl(args) => sitl::main(&args),
        Xtask::Test(args) => test::main(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        // The output of a test run ends with the count of its tests, so nothing is printed after it.
        Err(error::Error::Reported) => ExitCode::FAILURE,
        Err(error) => {
            tell!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
