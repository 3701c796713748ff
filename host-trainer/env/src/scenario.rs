//! The scenario: sizes of a world and how its PoIs are distributed.

use firmware_core::geometry::{MAP_SIDE_U, TICKS_PER_U};
use serde::{Deserialize, Serialize};

/// How the positions of the PoIs are drawn at reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PoiDistribution {
    /// Three normal clusters whose centres are at least a quarter of the side apart.
    #[default]
    Clustered,
    /// Each PoI uniformly on the map.
    Uniform,
}

/// Sizes of a world. [`Default`] is the paper's: 20 UAVs, 120 clustered PoIs, a map of
/// 200 u and 100 steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// Number of UAVs, 1 to [`Scenario::MAX_UAVS`].
    pub uavs: usize,
    /// Number of PoIs, 1 to [`Scenario::MAX_POIS`].
    pub pois: usize,
    /// How the positions of the PoIs are drawn.
    pub distribution: PoiDistribution,
    /// Side of the square map, u, [`Scenario::MIN_SIDE_U`] to [`Scenario::MAX_SIDE_U`].
    /// The distributions at reset scale with it; the ranges (10, 13 and 18 u) do not.
    pub side_u: f32,
    /// Steps in an episode, at least 1.
    pub steps: u32,
}

/// Why a scenario is not valid: the first size that is out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// `uavs` out of range.
    #[error("scenario: uavs = {0}; use 1 to {max}", max = Scenario::MAX_UAVS)]
    Uavs(usize),
    /// `pois` out of range.
    #[error("scenario: pois = {0}; use 1 to {max}", max = Scenario::MAX_POIS)]
    Pois(usize),
    /// `side_u` out of range or not a number.
    #[error("scenario: side_u = {0}; use {min} to {max} u", min = Scenario::MIN_SIDE_U, max = Scenario::MAX_SIDE_U)]
    Side(f32),
    /// `steps` is zero.
    #[error("scenario: steps = 0; an episode has at least 1 step")]
    Steps,
}

impl Default for Scenario {
    fn default() -> Self {
        Self { uavs: 20, pois: 120, distribution: PoiDistribution::Clustered, side_u: MAP_SIDE_U, steps: 100 }
    }
}

impl Scenario {
    /// Most UAVs in a world.
    pub const MAX_UAVS: usize = 16_384;
    /// Most PoIs in a world.
    pub const MAX_POIS: usize = 1 << 20;
    /// Smallest side of a map, u.
    pub const MIN_SIDE_U: f32 = 20.0;
    /// Largest side of a map, u: positions still resolve to a thousandth of a unit.
    pub const MAX_SIDE_U: f32 = 16_384.0;

    /// Half the side of the map, ticks (1/1024 u): the observation scales positions by it.
    #[must_use]
    pub fn half_side_ticks(&self) -> i32 {
        (self.side_u * (TICKS_PER_U as f32 / 2.0)) as i32
    }

    /// Checks every size.
    ///
    /// # Errors
    /// [`ScenarioError`] of the first field that is out of range.
    pub fn validate(&self) -> Result<(), ScenarioError> {
        if !(1..=Self::MAX_UAVS).contains(&self.uavs) {
            return Err(ScenarioError::Uavs(self.uavs));
        }
        if !(1..=Self::MAX_POIS).contains(&self.pois) {
            return Err(ScenarioError::Pois(self.pois));
        }
        if !(Self::MIN_SIDE_U..=Self::MAX_SIDE_U).contains(&self.side_u) {
            return Err(ScenarioError::Side(self.side_u));
        }
        if self.steps == 0 {
            return Err(ScenarioError::Steps);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid_and_each_bad_size_is_named() {
        let ok = Scenario::default();
        assert_eq!(ok.validate(), Ok(()));
        let bad = |change: fn(&mut Scenario)| {
            let mut s = Scenario::default();
            change(&mut s);
            s.validate().unwrap_err().to_string()
        };
        assert!(bad(|s| s.uavs = 0).contains("uavs = 0"));
        assert!(bad(|s| s.uavs = 70_000).contains("uavs = 70000"));
        assert!(bad(|s| s.pois = 0).contains("pois = 0"));
        assert!(bad(|s| s.side_u = f32::NAN).contains("side_u = NaN"));
        assert!(bad(|s| s.side_u = 5.0).contains("side_u = 5"));
        assert!(bad(|s| s.steps = 0).contains("steps = 0"));
    }
}
