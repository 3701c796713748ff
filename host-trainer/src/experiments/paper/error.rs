//! Why runs could not become results.

use crate::run::FolderError;
use covey_env::ScenarioError;
use covey_report::atomic::WriteError;
use covey_report::metrics::MetricsError;
use std::path::PathBuf;
use thiserror::Error;

/// Why runs could not be collected.
#[derive(Debug, Error)]
pub enum CollectError {
    /// A run folder is not sound.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// Its metrics are not.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// A folder cannot be listed.
    #[error("cannot list {path}")]
    List {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Runs of a group differ in more than algorithm and seed.
    #[error(
        "{path} has {key} = {found}, but {wanted} is wanted here as in all runs of its group; \
         give the same settings again, or choose another --out"
    )]
    Mismatch {
        /// The run folder.
        path: PathBuf,
        /// The first setting that differs.
        key: String,
        /// In the run.
        found: String,
        /// Wanted.
        wanted: String,
    },
    /// The two groups are of other worlds.
    #[error(
        "{path} has {key} = {found}, but the runs beside it have {wanted}: they cannot be compared; choose another --out"
    )]
    OtherWorlds {
        /// A run folder of the second group.
        path: PathBuf,
        /// The setting.
        key: &'static str,
        /// In the run.
        found: String,
        /// In the other group.
        wanted: String,
    },
    /// The actor file is not sound.
    #[error(
        "{path} holds no sound actor ({why}); delete it and evaluation.json beside it, and the same command makes both anew"
    )]
    Actor {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// Training went wrong.
    #[error(
        "row {row} of {path} holds a value that is no number: training went wrong; delete the run folder and use a lower learning_rate"
    )]
    NotFinite {
        /// The metrics file.
        path: PathBuf,
        /// The row, from 1.
        row: usize,
    },
    /// The worlds cannot be built.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Measurements cannot be written.
    #[error("measurements cannot be written as JSON")]
    Encode(#[from] serde_json::Error),
}
