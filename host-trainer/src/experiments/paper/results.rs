//! All numbers behind the page: `results.json`.

use super::kind::Kind;
use super::metric::Metric;
use crate::settings::current_name;
use covey_env::EpisodeMetrics;
use firmware_core::actor::Aggregation;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Version of the file.
const FORMAT: u32 = 1;

/// Why `results.json` cannot be used.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// It cannot be read.
    #[error("cannot read {path}; make it with `host-trainer experiment paper`")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is none.
    #[error("{path} holds no results that this program can read; train and measure anew")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// Of another version.
    #[error("{path} is of format {found}, this program reads format {FORMAT}")]
    Format {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
    /// Lists that belong together differ in length.
    #[error("{path}: the run {run} has curves of different lengths; make the file anew from the run folders")]
    Lengths {
        /// The file.
        path: PathBuf,
        /// The run.
        run: String,
    },
}

/// Metrics by round of training, means over the round's episodes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// Episodes at the end of each round.
    pub episodes: Vec<u64>,
    /// Episodic reward.
    pub reward: Vec<f64>,
    /// Coverage index.
    pub coverage: Vec<f64>,
    /// Energy index.
    pub energy: Vec<f64>,
    /// Policy loss.
    pub policy_loss: Vec<f64>,
    /// Individual covered PoIs.
    pub individual: Vec<f64>,
    /// Group covered PoIs.
    pub group: Vec<f64>,
}

impl Curves {
    /// A metric by round.
    #[must_use]
    pub fn of(&self, metric: Metric) -> &[f64] {
        match metric {
            Metric::Reward => &self.reward,
            Metric::Coverage => &self.coverage,
            Metric::Energy => &self.energy,
            Metric::PolicyLoss => &self.policy_loss,
            Metric::Individual => &self.individual,
            Metric::Group => &self.group,
        }
    }

    /// Whether all lists have a value for each round.
    fn even(&self) -> bool {
        [&self.reward, &self.coverage, &self.energy, &self.policy_loss, &self.individual, &self.group]
            .iter()
            .all(|list| list.len() == self.episodes.len())
    }
}

/// A policy's flights with one number of UAVs: means over the held-out worlds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Flight {
    /// UAVs.
    pub uavs: u16,
    /// Means over worlds.
    #[serde(flatten)]
    pub mean: EpisodeMetrics,
}

impl Flight {
    /// A metric's mean; none for the policy loss.
    #[must_use]
    pub const fn of(&self, metric: Metric) -> Option<f64> {
        Some(match metric {
            Metric::Reward => self.mean.reward,
            Metric::Coverage => self.mean.coverage,
            Metric::Energy => self.mean.energy,
            Metric::Individual => self.mean.individual,
            Metric::Group => self.mean.group,
            Metric::PolicyLoss => return None,
        })
    }
}

/// A trained run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Its aggregation.
    pub graph: String,
    /// Its seed.
    pub seed: u64,
    /// Its curves.
    pub curves: Curves,
    /// Its policy with other numbers of UAVs.
    pub flights: Vec<Flight>,
}

/// Runs of the same settings but for algorithm and seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// What the settings started from.
    pub kind: Kind,
    /// The settings that all runs share.
    pub settings: Vec<(String, String)>,
    /// The runs, by algorithm and seed.
    pub runs: Vec<RunResult>,
}

/// A hand-written policy's flights in the same worlds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Its name.
    pub policy: String,
    /// Its flights.
    pub flights: Vec<Flight>,
}

/// The experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Version of the file.
    pub format: u32,
    /// Numbers of UAVs flown.
    pub sizes: Vec<u16>,
    /// Held-out worlds of each number.
    pub worlds: u32,
    /// Their seed.
    pub world_seed: u64,
    /// Groups that have runs.
    pub groups: Vec<Group>,
    /// Hand-written policies.
    pub baselines: Vec<Baseline>,
}

impl Group {
    /// The runs of an algorithm, by seed.
    pub fn of(&self, graph: Aggregation) -> impl Iterator<Item = &RunResult> {
        self.runs.iter().filter(move |r| r.graph == graph.name())
    }

    /// The run of an algorithm and a seed.
    #[must_use]
    pub fn run(&self, graph: Aggregation, seed: u64) -> Option<&RunResult> {
        self.of(graph).find(|r| r.seed == seed)
    }

    /// Algorithms that have runs.
    #[must_use]
    pub fn graphs(&self) -> Vec<Aggregation> {
        Aggregation::ALL.into_iter().filter(|&g| self.of(g).next().is_some()).collect()
    }

    /// Seeds of all runs, ascending.
    #[must_use]
    pub fn seeds(&self) -> Vec<u64> {
        let mut seeds: Vec<u64> = self.runs.iter().map(|r| r.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        seeds
    }

    /// Episodes of a run.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.runs.iter().filter_map(|r| r.curves.episodes.last()).copied().max().unwrap_or(0)
    }

    /// A setting's value.
    #[must_use]
    pub fn setting(&self, name: &str) -> &str {
        self.settings.iter().find(|s| s.0 == name).map_or("?", |s| s.1.trim_matches('"'))
    }
}

impl Results {
    /// Of these groups and hand-written policies.
    #[must_use]
    pub const fn new(
        sizes: Vec<u16>,
        worlds: u32,
        world_seed: u64,
        groups: Vec<Group>,
        baselines: Vec<Baseline>,
    ) -> Self {
        Self { format: FORMAT, sizes, worlds, world_seed, groups, baselines }
    }

    /// The runs of a kind, if there are any.
    #[must_use]
    pub fn group(&self, kind: Kind) -> Option<&Group> {
        self.groups.iter().find(|g| g.kind == kind)
    }

    /// The file: JSON with a line for each run.
    ///
    /// # Errors
    /// Never for finite numbers.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        let line = serde_json::to_string(self)?;
        Ok(line.replace("{\"graph\":", "\n{\"graph\":").replace("{\"policy\":", "\n{\"policy\":") + "\n")
    }

    /// Reads the file.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let path = path.to_owned();
        let text =
            std::fs::read_to_string(&path).map_err(|source| ResultsError::Read { path: path.clone(), source })?;
        let mut found: Self =
            serde_json::from_str(&text).map_err(|source| ResultsError::Malformed { path: path.clone(), source })?;
        if found.format != FORMAT {
            return Err(ResultsError::Format { path, found: found.format });
        }
        // Files from before name some settings otherwise.
        for (name, _) in found.groups.iter_mut().flat_map(|g| &mut g.settings) {
            *name = current_name(name).to_owned();
        }
        match found.groups.iter().flat_map(|g| &g.runs).find(|r| !r.curves.even()) {
            Some(r) => Err(ResultsError::Lengths { path, run: format!("{}-seed{}", r.graph, r.seed) }),
            None => Ok(found),
        }
    }
}

/// Six digits: all that a figure can use.
#[must_use]
pub fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
