//! What trained policies are compared with.

use clap::ValueEnum;
use covey_env::baselines::{Centroid, Follower, Greedy, Hover, Planner, Random, RelayingPlanner, RememberingPlanner};
use covey_env::oracles::FlyToSites;
use covey_env::{Policy, policy_seed};
use firmware_core::memory::MAX_KNOWLEDGE;

/// Hand-written policies and oracles, as `--policy` names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReferencePolicy {
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
    /// The same with the memory of the board, in 200 bytes a UAV and step.
    Relaying,
    /// Flies to the best static sites, all PoIs known (central).
    Oracle,
    /// Starts at the best static sites (central).
    Parked,
}

impl ReferencePolicy {
    /// Its name in rows and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Hover => "hover",
            Self::Greedy => "greedy",
            Self::Centroid => "centroid",
            Self::Follower => "follower",
            Self::Planner => "planner",
            Self::Remembering => "remembering",
            Self::Relaying => "relaying",
            Self::Oracle => "oracle",
            Self::Parked => "parked",
        }
    }

    /// A fresh policy for world `index` of `seed`. Parked UAVs hover: the evaluation places them.
    pub(super) fn in_world(self, seed: u64, index: u64) -> Box<dyn Policy> {
        match self {
            Self::Random => Box::new(Random::new(seed, index)),
            Self::Hover | Self::Parked => Box::new(Hover),
            Self::Greedy => Box::new(Greedy::new()),
            Self::Centroid => Box::new(Centroid::new(seed, index)),
            Self::Follower => Box::new(Follower::new(policy_seed(seed, index))),
            Self::Planner => Box::new(Planner::new()),
            Self::Remembering => Box::new(RememberingPlanner::new()),
            Self::Relaying => Box::new(RelayingPlanner::new(MAX_KNOWLEDGE)),
            Self::Oracle => Box::new(FlyToSites::new()),
        }
    }
}
