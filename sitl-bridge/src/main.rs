//! Flies Covey's actor over MAVLink.

mod actor_file;

use clap::Parser;
use miette::IntoDiagnostic as _;

/// Flies Covey's actor over MAVLink.
#[derive(Parser)]
#[command(version)]
enum Command {
    /// Test an actor file on this computer, as is done before each flight.
    SelfTest(actor_file::SelfTest),
    /// Print an actor file's signature: the same number wherever the actor decides the same.
    Signature(actor_file::Signature),
}

fn main() -> miette::Result<()> {
    match Command::parse() {
        Command::SelfTest(args) => args.run().into_diagnostic(),
        Command::Signature(args) => args.run().into_diagnostic(),
    }
}
