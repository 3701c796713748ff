//! Settings that had another name: files, checkpoints and commands from before still work.

use std::fmt;

/// Old name and today's name.
const RENAMED: [Renamed; 11] = [
    Renamed { old: "segment", new: "rollout_steps" },
    Renamed { old: "worlds", new: "num_envs" },
    Renamed { old: "averaging", new: "ema_decay" },
    Renamed { old: "teacher", new: "cloning_weight" },
    Renamed { old: "teacher_episodes", new: "cloning_episodes" },
    Renamed { old: "uavs_least", new: "uavs_min" },
    Renamed { old: "uavs_most", new: "uavs_max" },
    Renamed { old: "other_law", new: "other_distribution_share" },
    Renamed { old: "link_loss", new: "radio_loss" },
    Renamed { old: "link_delay", new: "radio_delay" },
    Renamed { old: "scenario", new: "poi_distribution" },
];

/// A setting that was given by its old name. Shown, it says what to write instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Renamed {
    /// The name as given.
    pub old: &'static str,
    /// The name of today.
    pub new: &'static str,
}

impl fmt::Display for Renamed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is now `{}`", self.old, self.new)
    }
}

/// The entry of an old name.
pub fn renamed(key: &str) -> Option<Renamed> {
    RENAMED.into_iter().find(|r| r.old == key)
}

/// Today's name of a setting; a name that never was an old one stays as it is.
#[must_use]
pub fn current_name(key: &str) -> &str {
    renamed(key).map_or(key, |r| r.new)
}
