//! The command line.

mod paper;

use clap::{Args, Parser, Subcommand, ValueEnum};
use covey_env::radio::RadioSettings;
use firmware_core::observation::LEN;
use std::path::PathBuf;

pub use paper::ExperimentPaper;

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
        host-trainer eval --model actor.postcard --scenario uniform --decide argmax\n  \
        host-trainer eval --run runs/gcn-seed10 --float\n  \
        host-trainer eval --uavs 20,1000 --same-density --worlds 10\n  \
        host-trainer eval --link loss=0.1 --link loss=0.3,burst=5,delay_ms=2000\n  \
        host-trainer eval --actor qemu-m7 --worlds 10"
    )]
    Eval(Eval),
    /// Measure something at length and write a page with a picture.
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

/// Aggregation on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraphArg {
    /// Plain PPO.
    None,
    /// Graph convolution.
    Gcn,
    /// Graph attention.
    Gat,
}

/// PoiDistribution of the PoIs on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DistributionArg {
    /// Around three centres.
    Clustered,
    /// All over the map.
    Uniform,
}

/// Hand-written policies and oracles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PolicyArg {
    /// A random action in every step.
    Random,
    /// Never accelerates.
    Hover,
    /// The action whose next state gives the UAV most reward.
    Greedy,
    /// Flies to the middle of what no neighbour covers.
    Centroid,
    /// Flies to the place that the actor's own observation names the best.
    Follower,
    /// Values every place by what it and its neighbours see now, and flies to the best.
    Planner,
    /// The same with memory, told from UAV to UAV.
    Remembering,
    /// Flies to the best static sites, all PoIs known (central).
    Oracle,
    /// Starts at the best static sites (central).
    Parked,
}

/// How actions are taken from logits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DecideArg {
    /// Drawn in proportion to their probabilities.
    Sample,
    /// The most probable one.
    Argmax,
}

/// A part of training.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StageArg {
    /// Environment and observation, random actions.
    Env,
    /// These with actor and critic.
    Policy,
    /// Learning from what was played.
    Update,
    /// All of it.
    Train,
}

/// What computes the networks in training.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DeviceArg {
    /// This computer's processor.
    Cpu,
    /// An NVIDIA GPU; only in a program built with `--features cuda`.
    Cuda,
    /// A GPU through Vulkan, Metal or DirectX 12; only in a program built with `--features wgpu`.
    Wgpu,
}

/// What runs the actor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ActorArg {
    /// This computer.
    Host,
    /// The flight program on a Cortex-M7 (QEMU's mps2-an500).
    #[value(name = "qemu-m7")]
    QemuM7,
    /// The flight program on a Cortex-M4F (QEMU's mps2-an386).
    #[value(name = "qemu-m4f")]
    QemuM4f,
}

/// `train`.
#[derive(Debug, Args)]
pub struct Train {
    /// Settings file (TOML); `host-trainer settings` prints one with all defaults.
    #[arg(long, value_name = "F")]
    pub config: Option<PathBuf>,
    /// Aggregation of neighbours' features [default: gcn].
    #[arg(long)]
    pub graph: Option<GraphArg>,
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
    pub device: DeviceArg,
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

/// `eval`.
#[derive(Debug, Args)]
pub struct Eval {
    /// Actor file; or gcn, gat or none: those that come with Covey [default: gcn].
    #[arg(long, value_name = "FILE.postcard", conflicts_with_all = ["run", "policy"])]
    pub model: Option<PathBuf>,
    /// Run folder: its actor file, and with --float its float policy beside it.
    #[arg(long, value_name = "DIR", conflicts_with = "policy")]
    pub run: Option<PathBuf>,
    /// A hand-written policy instead.
    #[arg(long)]
    pub policy: Option<PolicyArg>,
    /// What decides: this computer, or the flight program on an emulated flight controller.
    /// Then every decision is also computed here and compared; a difference is an error.
    #[arg(long, default_value = "host", conflicts_with_all = ["policy", "float"])]
    pub actor: ActorArg,
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
    /// PoiDistribution of the PoIs.
    #[arg(long, default_value = "clustered")]
    pub scenario: DistributionArg,
    /// Held-out worlds.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub worlds: u32,
    /// Seed of the worlds.
    #[arg(long, value_name = "S", default_value_t = 777)]
    pub seed: u64,
    /// How actions are taken.
    #[arg(long, default_value = "sample")]
    pub decide: DecideArg,
    /// Messages between UAVs go over this link, such as loss=0.1,burst=3,delay_ms=2000 (a step
    /// has 2000 ms); may be repeated, a row each. Settings: loss, burst, delay_ms, jitter_ms,
    /// duplicate, reorder, corrupt, range_u; `perfect` for none of them.
    #[arg(long, value_name = "KEY=V,…", conflicts_with_all = ["policy", "float", "actor"])]
    pub link: Vec<RadioSettings>,
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

/// `experiment`.
#[derive(Debug, Subcommand)]
pub enum Experiment {
    /// Coverage over links that lose, delay, double, reorder and damage messages.
    #[command(after_help = "Example:\n  host-trainer experiment link --worlds 20 --out /tmp/link")]
    Link(ExperimentLink),
    /// The paper's experiments: plain PPO, GCN and GAT over several seeds, each flown with 5 to 30
    /// UAVs, and what the paper says of them judged.
    #[command(after_help = "Examples:\n  host-trainer experiment paper --quick --out /tmp/paper\n  \
        host-trainer experiment paper --seeds 10-14 --jobs 2\n  \
        host-trainer experiment paper --settings shipped --episodes 6000\n  \
        host-trainer experiment paper --report-only\n\
        The same command again goes on where it was stopped.")]
    Paper(ExperimentPaper),
}

/// `experiment link`.
#[derive(Debug, Args)]
pub struct ExperimentLink {
    /// Actor file; or gcn, gat or none: those that come with Covey [default: gcn].
    #[arg(long, value_name = "FILE.postcard")]
    pub model: Option<PathBuf>,
    /// UAVs.
    #[arg(long, value_name = "N", default_value_t = Self::default().uavs)]
    pub uavs: u16,
    /// PoiDistribution of the PoIs.
    #[arg(long, default_value = "clustered")]
    pub scenario: DistributionArg,
    /// Held-out worlds for each link.
    #[arg(long, value_name = "N", default_value_t = Self::default().worlds)]
    pub worlds: u32,
    /// Seed of the worlds.
    #[arg(long, value_name = "S", default_value_t = Self::default().seed)]
    pub seed: u64,
    /// Folder for link-loss.md and link-loss.svg, as in the documents.
    #[arg(long, value_name = "DIR", default_value = "docs")]
    pub out: PathBuf,
    /// Also prints one JSON array of rows.
    #[arg(long)]
    pub json: bool,
    /// Threads [default: one a core]. Results do not depend on it.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

impl Default for ExperimentLink {
    fn default() -> Self {
        Self {
            model: None,
            uavs: 20,
            scenario: DistributionArg::Clustered,
            worlds: 200,
            seed: 777,
            out: "docs".into(),
            json: false,
            threads: None,
        }
    }
}

/// `export`.
#[derive(Debug, Args)]
pub struct Export {
    /// Run folder.
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    /// Divides the logits by this instead of the run's `temperature`.
    #[arg(long, value_name = "T")]
    pub temperature: Option<f64>,
    /// Actor file to write.
    #[arg(long, value_name = "FILE.postcard")]
    pub out: PathBuf,
}

/// `inspect`.
#[derive(Debug, Args)]
pub struct Inspect {
    /// Actor file; or gcn, gat or none: those that come with Covey.
    #[arg(value_name = "FILE.postcard")]
    pub file: PathBuf,
}

/// `report`.
#[derive(Debug, Args)]
pub struct Report {
    /// Run folders.
    #[arg(value_name = "RUN_DIR", required = true)]
    pub runs: Vec<PathBuf>,
    /// Page to write [default: report.html in the run folder, compare.html for several].
    #[arg(long, value_name = "FILE.html")]
    pub out: Option<PathBuf>,
}

/// `bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// Aggregation.
    #[arg(long, default_value = "gcn")]
    pub graph: GraphArg,
    /// Threads [default: one a core].
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What computes the networks; anything but `cpu` is measured beside the CPU.
    #[arg(long, default_value = "cpu")]
    pub device: DeviceArg,
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
    pub stage: StageArg,
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
