//! `train`.

use super::device::Device;
use crate::settings::parser;
use clap::Args;
use firmware_core::actor::Aggregation;
use std::path::PathBuf;

/// `train`.
#[derive(Debug, Args)]
pub struct Train {
    /// Settings file (TOML); `host-trainer settings` prints one with all defaults.
    #[arg(long, value_name = "F")]
    pub config: Option<PathBuf>,
    /// Aggregation of neighbours' features [default: gcn].
    #[arg(long, value_parser = parser::<Aggregation>())]
    pub graph: Option<Aggregation>,
    /// Training episodes.
    #[arg(long, value_name = "N")]
    pub episodes: Option<u32>,
    /// Seed of the run.
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
    /// Run folder [default: runs/GRAPH-seedS, numbered when taken].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads [default: one a core, at most one a shard]. Results do not depend on it.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What computes the networks. Worlds stay on the CPU.
    #[arg(long, default_value = "cpu")]
    pub device: Device,
    /// Sets one setting; may be repeated.
    #[arg(long, value_name = "key=value")]
    pub set: Vec<String>,
    /// Goes on with an interrupted run, exactly.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["config", "graph", "episodes", "seed", "out", "set"])]
    pub resume: Option<PathBuf>,
    /// No progress, no summary: only errors.
    #[arg(long)]
    pub quiet: bool,
}
