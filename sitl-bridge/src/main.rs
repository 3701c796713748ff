//! Flies Covey's actor over MAVLink.

use clap::Parser;
use sitl_bridge::commands::Command;

fn main() -> miette::Result<()> {
    Command::parse().run()
}
