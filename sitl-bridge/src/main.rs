//! Flies Covey's actor over MAVLink.

use clap::Parser;
use sitl_bridge::commands::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    Cli::parse().run().unwrap_or_else(|report| {
        eprintln!("Error: {report:?}");
        ExitCode::FAILURE
    })
}
