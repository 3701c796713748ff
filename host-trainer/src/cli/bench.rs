//! `bench`.

use super::device::Device;
use crate::settings::parser;
use clap::{Args, ValueEnum};
use firmware_core::actor::Aggregation;
use firmware_core::observation::LEN;

/// `bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// Aggregation.
    #[arg(long, default_value = "gcn", value_parser = parser::<Aggregation>())]
    pub graph: Aggregation,
    /// Threads [default: one a core].
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What computes the networks; anything but `cpu` is measured beside the CPU.
    #[arg(long, default_value = "cpu")]
    pub device: Device,
    /// Runs of each stage; the medians are printed.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub repeats: u32,
    /// Numbers of a compact observation that the networks take, the first ones: 1 to 160
    /// [default: all].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=LEN as i64))]
    pub inputs: Option<u16>,
    /// Another program's measurement, a command for the shell: it and the stage take turns,
    /// and the ratios of the rates are printed.
    #[arg(long, value_name = "COMMAND")]
    pub against: Option<String>,
    /// What is compared with it.
    #[arg(long, default_value = "train", requires = "against")]
    pub stage: BenchStage,
    /// What stands before the rate in the output of --against: the last number after it counts
    /// [default: agent_steps_per_s, or where that is not found, rate].
    #[arg(long, value_name = "TEXT", requires = "against")]
    pub marker: Option<String>,
    /// Sets one setting; may be repeated.
    #[arg(long, value_name = "key=value")]
    pub set: Vec<String>,
    /// One JSON object instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// A part of training.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchStage {
    /// Environment and observation, random actions.
    Env,
    /// These with actor and critic.
    Policy,
    /// Learning from what was played.
    Update,
    /// All of it.
    Train,
}
