//! A run folder: settings, metrics, events, checkpoints, actor file, report.

use super::checkpoint::{Checkpoint, CheckpointError};
use super::lock::RunLock;
use crate::settings::{Settings, SettingsError, word_of};
use covey_report::atomic;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a run folder cannot be used.
#[derive(Debug, Error)]
pub enum FolderError {
    /// It already holds a run.
    #[error("{0} already holds a run; resume it with `host-trainer train --resume {0}`, or choose another --out")]
    Taken(PathBuf),
    /// It is not a run folder.
    #[error("{0} is not a run folder (it has no config.toml)")]
    NotARun(PathBuf),
    /// It cannot be made.
    #[error("cannot make the folder {path}; choose another --out or mend its permissions")]
    Make {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] atomic::WriteError),
    /// Its settings cannot be read.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Its checkpoint cannot be used.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// Settings and checkpoint are of different runs.
    #[error(
        "{path}/config.toml says {key} = {config}, but the checkpoint was made with {checkpoint}; \
         put the old value back, or start a new run with --config {path}/config.toml --out elsewhere"
    )]
    OtherSettings {
        /// The run folder.
        path: PathBuf,
        /// The first setting that differs.
        key: String,
        /// In the file.
        config: String,
        /// In the checkpoint.
        checkpoint: String,
    },
    /// The checkpoint does not tell all settings.
    #[error(
        "the checkpoint of {path} was made before there were the settings {keys}, so it cannot go on as it began; \
         start a new run with --config {path}/config.toml --out elsewhere"
    )]
    Older {
        /// The run folder.
        path: PathBuf,
        /// The settings that it does not tell.
        keys: String,
    },
}

/// A run folder: the paths of what a run writes, see `docs/run-folder.md`.
#[derive(Clone, Debug)]
pub struct RunFolder(PathBuf);

impl RunFolder {
    /// Starts a run folder with these settings; what a start that failed has left there is replaced. Without `out` it is `runs/GRAPH-seedN`,
    /// with a number behind it when that is taken.
    ///
    /// # Errors
    /// [`FolderError::Taken`] when `out` holds a run, or when it cannot be written.
    pub fn create(out: Option<&Path>, settings: &Settings) -> Result<Self, FolderError> {
        let folder = Self(out.map_or_else(|| free_name(settings), Path::to_owned));
        if folder.config().exists() {
            if !folder.is_failed_start() {
                return Err(FolderError::Taken(folder.0));
            }
            // Empty, and in the way of a new one.
            let _ = std::fs::remove_file(folder.metrics());
        }
        let make = |path: PathBuf| std::fs::create_dir_all(&path).map_err(|source| FolderError::Make { path, source });
        make(folder.checkpoints())?;
        atomic::write(folder.config(), settings.to_toml().as_bytes())?;
        Ok(folder)
    }

    /// Whether it is what a start leaves that failed before anything was trained: no checkpoint, and no row of
    /// metrics.
    fn is_failed_start(&self) -> bool {
        // Another process may be about to write its first checkpoint.
        let Ok(_lock) = RunLock::take(&self.0, |_| {}) else { return false };
        let no_row = std::fs::metadata(self.metrics()).map_or(true, |m| m.len() == 0);
        no_row && matches!(Checkpoint::newest(&self.checkpoints()), Err(CheckpointError::None(_)))
    }

    /// An existing run folder.
    ///
    /// # Errors
    /// [`FolderError::NotARun`] without a `config.toml`.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        let folder = Self(path.to_owned());
        if folder.config().is_file() { Ok(folder) } else { Err(FolderError::NotARun(folder.0)) }
    }

    /// Its settings.
    ///
    /// # Errors
    /// When `config.toml` is not sound.
    pub fn settings(&self) -> Result<Settings, FolderError> {
        let mut settings = Settings::default();
        settings.merge_file(&self.config())?;
        settings.validate()?;
        Ok(settings)
    }

    /// Settings and newest checkpoint, which must belong together.
    ///
    /// # Errors
    /// See [`FolderError`].
    pub fn load(&self) -> Result<(Settings, Checkpoint), FolderError> {
        let settings = self.settings()?;
        let checkpoint = Checkpoint::newest(&self.checkpoints())?;
        let mut stored = Settings::default();
        stored.merge(&checkpoint.settings, "the checkpoint's settings")?;
        let unnamed = Settings::unnamed(&checkpoint.settings);
        if !unnamed.is_empty() {
            return Err(FolderError::Older { path: self.0.clone(), keys: unnamed.join(", ") });
        }
        if let Some((key, config, made)) = settings.first_difference(&stored) {
            return Err(FolderError::OtherSettings { path: self.0.clone(), key, config, checkpoint: made });
        }
        Ok((settings, checkpoint))
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Its name, for titles.
    #[must_use]
    pub fn name(&self) -> String {
        self.0.file_name().map_or_else(|| self.0.display().to_string(), |n| n.to_string_lossy().into_owned())
    }

    /// `config.toml`.
    #[must_use]
    pub fn config(&self) -> PathBuf {
        self.0.join("config.toml")
    }

    /// `metrics.jsonl`.
    #[must_use]
    pub fn metrics(&self) -> PathBuf {
        self.0.join("metrics.jsonl")
    }

    /// `events/`: TensorBoard.
    #[must_use]
    pub fn events(&self) -> PathBuf {
        self.0.join("events")
    }

    /// `checkpoints/`.
    #[must_use]
    pub fn checkpoints(&self) -> PathBuf {
        self.0.join("checkpoints")
    }

    /// `actor.postcard`.
    #[must_use]
    pub fn actor(&self) -> PathBuf {
        self.0.join("actor.postcard")
    }

    /// `evaluation.json`.
    #[must_use]
    pub fn evaluation(&self) -> PathBuf {
        self.0.join("evaluation.json")
    }

    /// `picture.svg`.
    #[must_use]
    pub fn picture(&self) -> PathBuf {
        self.0.join("picture.svg")
    }

    /// `report.html`.
    #[must_use]
    pub fn report(&self) -> PathBuf {
        self.0.join("report.html")
    }
}

fn free_name(s: &Settings) -> PathBuf {
    let name = format!("{}-seed{}", word_of(s.graph), s.seed);
    let numbered = (2..).map(|k| format!("{name}-{k}"));
    std::iter::once(name.clone())
        .chain(numbered)
        .map(|n| Path::new("runs").join(n))
        .find(|p| !p.exists())
        .unwrap_or_else(|| Path::new("runs").join(name))
}
