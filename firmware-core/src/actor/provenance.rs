//! Where an actor comes from.

use serde::{Deserialize, Serialize};

/// Where an actor comes from: for people and logs, not used in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance<'a> {
    /// Program and version that wrote it.
    pub trainer: &'a str,
    /// Scenario it was trained on.
    pub scenario: &'a str,
    /// UAVs in a training world.
    pub uavs: u16,
    /// Seed of the training run.
    pub seed: u64,
    /// Training episodes.
    pub episodes: u32,
    /// Worlds of the evaluation behind the two coverages (0: not evaluated).
    pub worlds: u32,
    /// Coverage index of the float policy, in 1/10,000.
    pub float_coverage: u16,
    /// Coverage index of this int8 actor, in 1/10,000.
    pub int8_coverage: u16,
}
