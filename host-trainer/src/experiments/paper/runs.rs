//! The run folders of the experiment.

use super::error::CollectError;
use super::kind::Kind;
use crate::run::RunFolder;
use crate::settings::{Settings, word_of};
use std::path::{Path, PathBuf};

/// A run folder of the experiment with its settings.
#[derive(Clone, Debug)]
pub struct Run {
    /// The folder.
    pub folder: RunFolder,
    /// Its settings.
    pub settings: Settings,
}

/// Where the runs of a kind are.
#[must_use]
pub fn folder_of(out: &Path, kind: Kind) -> PathBuf {
    out.join("runs").join(kind.name())
}

/// Folder name of a run.
#[must_use]
pub fn run_name(s: &Settings) -> String {
    format!("{}-seed{}", word_of(s.graph), s.seed)
}

/// Run folders of a kind, by algorithm and seed; those without settings (a run that was cut
/// off as it was made) are left out.
///
/// # Errors
/// When a folder cannot be read.
pub fn runs(out: &Path, kind: Kind) -> Result<Vec<Run>, CollectError> {
    let path = folder_of(out, kind);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let list = |source| CollectError::List { path: path.clone(), source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&path).map_err(list)? {
        let Ok(folder) = RunFolder::open(&entry.map_err(list)?.path()) else { continue };
        found.push(Run { settings: folder.settings()?, folder });
    }
    found.sort_by_key(|r| (r.settings.graph as u8, r.settings.seed));
    Ok(found)
}

/// Whether a run is done: trained and measured, which comes after quantising.
#[must_use]
pub fn finished(folder: &RunFolder) -> bool {
    folder.evaluation().is_file()
}

/// Refuses settings that differ in more than algorithm and seed from the runs of the group.
///
/// # Errors
/// [`CollectError::Mismatch`] names the first such run and setting.
pub fn check(runs: &[Run], wanted: &Settings) -> Result<(), CollectError> {
    for run in runs {
        let aligned = Settings { graph: wanted.graph, seed: wanted.seed, ..run.settings.clone() };
        if let Some((key, found, wanted)) = aligned.first_difference(wanted) {
            return Err(CollectError::Mismatch { path: run.folder.path().to_owned(), key, found, wanted });
        }
    }
    Ok(())
}
