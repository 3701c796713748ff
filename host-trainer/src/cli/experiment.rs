//! `experiment`.

use crate::experiments::paper::Kind;
use crate::settings::parser;
use clap::{Args, Subcommand};
use covey_env::PoiDistribution;
use firmware_core::actor::Aggregation;
use std::path::PathBuf;

/// `experiment`.
#[derive(Debug, Subcommand)]
pub enum Experiment {
    /// Coverage over radios that lose, delay, double, reorder and damage messages.
    #[command(after_help = "Example:\n  host-trainer experiment radio --worlds 20 --out /tmp/radio")]
    Radio(ExperimentRadio),
    /// The paper's experiments: plain PPO, GCN and GAT over several seeds, each flown with 5 to 30
    /// UAVs, and what the paper says of them judged.
    #[command(after_help = "Examples:\n  host-trainer experiment paper --quick --out /tmp/paper\n  \
        host-trainer experiment paper --seeds 10-14 --jobs 2\n  \
        host-trainer experiment paper --settings shipped --episodes 6000\n  \
        host-trainer experiment paper --report-only\n\
        The same command again goes on where it was stopped.")]
    Paper(ExperimentPaper),
}

/// `experiment radio`.
#[derive(Debug, Args)]
pub struct ExperimentRadio {
    /// Actor file; or gcn, gat or none: those that come with Covey [default: gcn].
    #[arg(long, value_name = "FILE.postcard")]
    pub model: Option<PathBuf>,
    /// UAVs.
    #[arg(long, value_name = "N", default_value_t = Self::default().uavs)]
    pub uavs: u16,
    /// How the PoIs are distributed.
    #[arg(long, default_value = "clustered", value_parser = parser::<PoiDistribution>())]
    pub poi_distribution: PoiDistribution,
    /// Held-out worlds for each radio.
    #[arg(long, value_name = "N", default_value_t = Self::default().worlds)]
    pub worlds: u32,
    /// Seed of the worlds.
    #[arg(long, value_name = "S", default_value_t = Self::default().seed)]
    pub seed: u64,
    /// Folder for radio-loss.md and radio-loss.svg, as in the documents.
    #[arg(long, value_name = "DIR", default_value = "docs")]
    pub out: PathBuf,
    /// Also prints one JSON array of rows.
    #[arg(long)]
    pub json: bool,
    /// Threads [default: one a core]. Results do not depend on it.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

impl Default for ExperimentRadio {
    fn default() -> Self {
        Self {
            model: None,
            uavs: 20,
            poi_distribution: PoiDistribution::Clustered,
            worlds: 200,
            seed: 777,
            out: "docs".into(),
            json: false,
            threads: None,
        }
    }
}

/// `experiment paper`.
#[derive(Debug, Args)]
pub struct ExperimentPaper {
    /// Which settings the runs start from; both kinds stand in one report when they have the
    /// same --out.
    #[arg(long, default_value = "paper")]
    pub settings: Kind,
    /// Algorithms [default: none,gcn,gat; with --settings shipped none,gcn].
    #[arg(long, value_name = "G,G", value_delimiter = ',', value_parser = parser::<Aggregation>())]
    pub graphs: Vec<Aggregation>,
    /// Seeds, as 10-14 or 1,2,5 [default: 10-14].
    #[arg(long, value_name = "S,S")]
    pub seeds: Option<String>,
    /// Training episodes of each run [default: 6000; with --settings shipped the usual].
    #[arg(long, value_name = "N")]
    pub episodes: Option<u32>,
    /// Sets one setting of all runs; may be repeated.
    #[arg(long, value_name = "key=value")]
    pub set: Vec<String>,
    /// Held-out worlds for each number of UAVs [default: 100; with --report-only as flown].
    #[arg(long, value_name = "N")]
    pub worlds: Option<u32>,
    /// Folder of the experiment: runs/, report.md, figures/ and results.json.
    #[arg(long, value_name = "DIR", default_value = "runs/paper")]
    pub out: PathBuf,
    /// Runs that train at the same time [default: one a thread]. Results do not depend on it.
    #[arg(long, value_name = "K")]
    pub jobs: Option<usize>,
    /// Threads of all runs together [default: one a core]. Results do not depend on it.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Two seeds, short runs of small networks, 3 worlds: everything in seconds, to see that it
    /// works. Takes --set and the rest as usual.
    #[arg(long)]
    pub quick: bool,
    /// Trains nothing: writes the report of the runs that are finished, or of results.json
    /// where there are no runs.
    #[arg(long, conflicts_with_all = ["settings", "graphs", "seeds", "episodes", "set", "jobs", "quick"])]
    pub report_only: bool,
    /// No progress, no summary: only errors.
    #[arg(long)]
    pub quiet: bool,
}
