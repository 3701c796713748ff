//! `experiment paper`.

use super::GraphArg;
use crate::experiments::paper::Kind;
use clap::Args;
use std::path::PathBuf;

/// `experiment paper`.
#[derive(Debug, Args)]
pub struct ExperimentPaper {
    /// Which settings the runs start from; both kinds stand in one report when they have the
    /// same --out.
    #[arg(long, default_value = "paper")]
    pub settings: Kind,
    /// Algorithms [default: none,gcn,gat; with --settings shipped none,gcn].
    #[arg(long, value_name = "G,G", value_delimiter = ',')]
    pub graphs: Vec<GraphArg>,
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
