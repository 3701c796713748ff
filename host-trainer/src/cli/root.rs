//! The program and its commands.

use super::bench::Bench;
use super::eval::Eval;
use super::experiment::Experiment;
use super::files::{Export, Inspect, Report};
use super::train::Train;
use clap::{Parser, Subcommand};

/// Train, measure and export Covey's policy.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Train a policy, quantise it, measure it and write a report.
    #[command(
        after_help = "Examples:\n  host-trainer train\n  host-trainer train --graph gat --seed 3 --out runs/gat3\n  \
        host-trainer train --config my.toml --set learning_rate=3e-4 --set entropy_end=0.001\n  \
        host-trainer train --resume runs/gat3"
    )]
    Train(Train),
    /// Measure a policy on held-out worlds.
    #[command(
        after_help = "Examples:\n  host-trainer eval\n  host-trainer eval --policy centroid --uavs 5,10,20 --json\n  \
        host-trainer eval --model actor.postcard --poi-distribution uniform --decide argmax\n  \
        host-trainer eval --run runs/gcn-seed10 --float\n  \
        host-trainer eval --uavs 20,1000 --same-density --worlds 10\n  \
        host-trainer eval --radio loss=0.1 --radio loss=0.3,burst=5,delay_ms=2000\n  \
        host-trainer eval --actor qemu-m7 --worlds 10"
    )]
    Eval(Eval),
    /// Run a study at length and write a page with figures.
    #[command(subcommand)]
    Experiment(Experiment),
    /// Quantise the newest checkpoint of a run into an actor file.
    #[command(after_help = "Example:\n  host-trainer export runs/gcn-seed10 --out actor.postcard")]
    Export(Export),
    /// Check an actor file and show what is in it.
    #[command(after_help = "Example:\n  host-trainer inspect actor.postcard")]
    Inspect(Inspect),
    /// Write a run's report again, or one that compares several runs.
    #[command(after_help = "Examples:\n  host-trainer report runs/gcn-seed10\n  \
        host-trainer report runs/gcn-seed10 runs/gat-seed10 --out compare.html")]
    Report(Report),
    /// Measure how fast this machine trains.
    #[command(after_help = "Examples:\n  host-trainer bench\n  host-trainer bench --graph gat --threads 1 --json\n  \
        host-trainer bench --against ./other.sh --stage env --repeats 5\n  \
        host-trainer bench --device cuda --set num_envs=512 --set minibatch=16000")]
    Bench(Bench),
    /// List every setting of a training run with its default and meaning.
    #[command(after_help = "Example:\n  host-trainer settings > my.toml")]
    Settings,
}
