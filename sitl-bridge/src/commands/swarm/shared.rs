//! What both ways of flying a swarm have in common.

use crate::commands::args::{ActorArgs, SigningArgs, TimingArgs};
use std::path::PathBuf;

/// Arguments with and without `--sim`.
#[derive(clap::Args)]
pub(super) struct SharedArgs {
    /// Number of UAVs.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=255))]
    pub count: u16,
    /// End with one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Folder for recordings of all MAVLink traffic, one file a UAV; with --sim each world's
    /// mission too.
    #[arg(long, value_name = "FOLDER", alias = "tlogs")]
    pub tlog: Option<PathBuf>,
    /// Print all notices and events.
    #[arg(long, short)]
    pub verbose: bool,
    #[command(flatten)]
    pub actor: ActorArgs,
    #[command(flatten)]
    pub timing: TimingArgs,
    #[command(flatten)]
    pub signing: SigningArgs,
}
