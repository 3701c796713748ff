//! Flies Covey's actor over MAVLink.

use clap::Parser;
use sitl_bridge::commands::Cli;
use sitl_bridge::outlet;
use std::process::ExitCode;

fn main() -> ExitCode {
    let status = Cli::parse().run().unwrap_or_else(|report| {
        outlet::say(&format!("Error: {report:?}"));
        ExitCode::FAILURE
    });
    outlet::drain();
    status
}
