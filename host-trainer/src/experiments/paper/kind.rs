//! The two groups of runs and their settings.

use super::design::{ALGORITHMS, WORLDS};
use crate::settings::{Settings, keys};
use clap::ValueEnum;
use covey_env::ObservationForm;
use firmware_core::actor::Aggregation;
use serde::{Deserialize, Serialize};

/// Which settings the runs of a group start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The paper's: its observation, its reward, no behaviour cloning, and what flies is the last policy as it was trained.
    Paper,
    /// Covey's defaults.
    Shipped,
}

impl Kind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Shipped];

    /// As on the command line, and the folder of its runs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Shipped => "shipped",
        }
    }

    /// In headings.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Paper => "the paper's setting",
            Self::Shipped => "Covey's defaults",
        }
    }

    /// Algorithms that are trained unless others are asked for.
    #[must_use]
    pub const fn graphs(self) -> &'static [Aggregation] {
        match self {
            Self::Paper => &ALGORITHMS,
            Self::Shipped => &[Aggregation::None, Aggregation::Gcn],
        }
    }

    /// Settings before any `--set`.
    #[must_use]
    pub fn settings(self) -> Settings {
        match self {
            Self::Paper => Settings {
                observation: ObservationForm::Cells,
                uavs: 20,
                uavs_max: 0,
                other_distribution_share: 0.0,
                episodes: 6000,
                learning_rate_end: 0.1,
                gamma: 0.97,
                entropy_end: 0.001,
                overlap_cost: 0.0,
                cloning_weight: 0.0,
                ema_decay: 0.0,
                temperature: 1.0,
                ..Settings::default()
            },
            Self::Shipped => Settings::default(),
        }
    }
}

/// Settings of `--quick`: runs of about a second that learn next to nothing.
pub const QUICK: [&str; 12] = [
    "episodes=24",
    "num_envs=4",
    "shards=2",
    "steps=40",
    "rollout_steps=20",
    "hidden=16",
    "feature=8",
    "head=16",
    "epochs=1",
    "minibatch=800",
    "eval_worlds=3",
    "calibration_worlds=2",
];

/// Every setting but those in which the runs of a group differ: name and value.
#[must_use]
pub fn common(settings: &Settings) -> Vec<(String, String)> {
    let entries = settings.entries().into_iter().filter(|(key, _)| !["graph", "seed"].contains(key));
    entries.map(|(key, value)| (key.to_owned(), value)).collect()
}

/// What has to be typed to train these runs.
#[must_use]
pub fn command(kind: Kind, graphs: &[&str], seeds: &[u64], settings: &[(String, String)], worlds: u32) -> String {
    let mut command = String::from("host-trainer experiment paper");
    if kind != Kind::Paper {
        command += &format!(" --settings {}", kind.name());
    }
    if graphs.iter().ne(kind.graphs().iter().map(|g| g.name()).collect::<Vec<_>>().iter()) {
        command += &format!(" --graphs {}", graphs.join(","));
    }
    let seeds = seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(",");
    if seeds != "10,11,12,13,14" {
        command += &format!(" --seeds {seeds}");
    }
    if worlds != WORLDS {
        command += &format!(" --worlds {worlds}");
    }
    let base = common(&kind.settings());
    // Settings that other versions had are left out.
    for (key, value) in settings.iter().filter(|s| !base.contains(s) && keys().iter().any(|k| k.name == s.0)) {
        command += &format!(" --set {key}={}", value.trim_matches('"'));
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_names_what_differs_from_its_group() {
        let settings = |kind: Kind, set: &str| {
            let mut s = kind.settings();
            s.set(set).unwrap();
            common(&s)
        };
        let seeds = [10, 11, 12, 13, 14];
        let all = ["none", "gcn", "gat"];
        assert_eq!(
            command(Kind::Paper, &all, &seeds, &settings(Kind::Paper, "cloning_weight=0"), 100),
            "host-trainer experiment paper"
        );
        assert_eq!(
            command(Kind::Shipped, &all, &[1, 2], &settings(Kind::Shipped, "poi_distribution=uniform"), 10),
            "host-trainer experiment paper --settings shipped --graphs none,gcn,gat --seeds 1,2 --worlds 10 --set poi_distribution=uniform"
        );
    }

    #[test]
    fn the_quick_settings_go_together() {
        for kind in Kind::ALL {
            let mut s = kind.settings();
            QUICK.iter().try_for_each(|set| s.set(set).map(|_| ())).unwrap();
            s.validate().unwrap();
        }
    }
}
