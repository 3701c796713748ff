//! Commands that read run folders and actor files: `export`, `inspect`, `report`.

use clap::Args;
use std::path::PathBuf;

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
