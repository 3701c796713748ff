//! `eval`.

use crate::eval::ReferencePolicy;
use crate::settings::parser;
use clap::{Args, ValueEnum};
use covey_env::PoiDistribution;
use covey_env::radio::RadioSettings;
use firmware_core::actor::Mode;
use std::path::PathBuf;

/// `eval`.
#[derive(Debug, Args)]
pub struct Eval {
    /// Actor file; or gcn, gat or none: those that come with Covey [default: gcn].
    #[arg(long, value_name = "FILE.postcard", conflicts_with_all = ["run", "policy"])]
    pub model: Option<PathBuf>,
    /// Run folder: its actor file, and with --float its float policy beside it.
    #[arg(long, value_name = "DIR", conflicts_with = "policy")]
    pub run: Option<PathBuf>,
    /// A hand-written policy or an oracle instead of an actor.
    #[arg(long)]
    pub policy: Option<ReferencePolicy>,
    /// What decides: this computer, or the flight program on an emulated flight controller.
    /// Then every decision is also computed here and compared; a difference is an error.
    #[arg(long, default_value = "host", conflicts_with_all = ["policy", "float"])]
    pub actor: Processor,
    /// The flight program for --actor qemu-… [default: where `cargo xtask targets` puts it].
    #[arg(long, value_name = "ELF", requires = "actor")]
    pub image: Option<PathBuf>,
    /// Numbers of UAVs.
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "20")]
    pub uavs: Vec<u16>,
    /// The map and the number of PoIs grow and shrink with the number of UAVs: as many of both
    /// to the area as with 20 UAVs (or as many as the run was trained with).
    #[arg(long)]
    pub same_density: bool,
    /// How the PoIs are distributed.
    #[arg(long, default_value = "clustered", value_parser = parser::<PoiDistribution>())]
    pub poi_distribution: PoiDistribution,
    /// Held-out worlds.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub worlds: u32,
    /// Seed of the worlds.
    #[arg(long, value_name = "S", default_value_t = 777)]
    pub seed: u64,
    /// How actions are taken from the policy's probabilities.
    #[arg(long, default_value = "sample", value_parser = parser::<Mode>())]
    pub decide: Mode,
    /// Messages between UAVs go over this radio, such as loss=0.1,burst=3,delay_ms=2000 (a step
    /// has 2000 ms); may be repeated, a row each. Settings: loss, burst, delay_ms, jitter_ms,
    /// duplicate, reorder, corrupt, range_u; `perfect` for none of them.
    #[arg(long, value_name = "KEY=V,…", conflicts_with_all = ["policy", "float", "actor"])]
    pub radio: Vec<RadioSettings>,
    /// Measures the float policy beside the int8 actor, and how often both would choose
    /// the same (needs --run).
    #[arg(long, requires = "run")]
    pub float: bool,
    /// One JSON array of rows instead of a table.
    #[arg(long)]
    pub json: bool,
    /// Threads, or emulated boards with --actor qemu-… [default: one a core].
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

/// The processor that runs the actor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Processor {
    /// This computer.
    Host,
    /// The flight program on a Cortex-M7 (QEMU's mps2-an500).
    #[value(name = "qemu-m7")]
    QemuM7,
    /// The flight program on a Cortex-M4F (QEMU's mps2-an386).
    #[value(name = "qemu-m4f")]
    QemuM4f,
}
