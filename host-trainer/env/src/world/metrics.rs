//! The metrics of an episode.

use super::score::Score;
use serde::{Deserialize, Serialize};

/// Metrics of an episode over the states after its steps so far; the spawn state is not scored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EpisodeMetrics {
    /// Mean over steps of PoIs covered by any UAV / all PoIs, 0 to 1.
    pub coverage: f64,
    /// The same, after the last step alone.
    pub coverage_last: f64,
    /// Mean of energy over steps and UAVs, 0.5 (hovering) to 1 (full speed).
    pub energy: f64,
    /// Mean over steps and UAVs of PoIs that the UAV alone covers in its group.
    pub individual: f64,
    /// Mean over steps and UAVs of PoIs that its group covers.
    pub group: f64,
    /// Reward summed over steps, mean over UAVs.
    pub reward: f64,
    /// Jain's index of the time each PoI was covered: (Σt)² / (P Σt²), 1/P to 1; 0 when
    /// no PoI ever was.
    pub fairness: f64,
}

impl EpisodeMetrics {
    /// Names of the metrics in files and tables, in the order of [`EpisodeMetrics::values`].
    pub const NAMES: [&'static str; 7] =
        ["coverage", "coverage_last", "energy", "individual", "group", "reward", "fairness"];

    /// The seven values, in the order of [`EpisodeMetrics::NAMES`].
    #[must_use]
    pub const fn values(&self) -> [f64; 7] {
        [self.coverage, self.coverage_last, self.energy, self.individual, self.group, self.reward, self.fairness]
    }

    /// The metrics from values in the order of [`EpisodeMetrics::NAMES`].
    #[must_use]
    pub const fn from_values(v: [f64; 7]) -> Self {
        Self {
            coverage: v[0],
            coverage_last: v[1],
            energy: v[2],
            individual: v[3],
            group: v[4],
            reward: v[5],
            fairness: v[6],
        }
    }
}

/// Sums over steps from which the metrics follow.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Totals {
    steps: u32,
    covered: u64,
    individual: u64,
    group: u64,
    energy: f64,
    reward: f64,
}

impl Totals {
    /// Adds the state after a step.
    pub(crate) fn add(&mut self, score: &Score) {
        let count = |v: &[u32]| v.iter().map(|&c| u64::from(c)).sum::<u64>();
        let sum = |v: &[f32]| f64::from(v.iter().sum::<f32>());
        self.steps += 1;
        self.covered += score.covered as u64;
        self.individual += count(&score.individual);
        self.group += count(&score.group);
        self.energy += sum(&score.energy);
        self.reward += sum(&score.reward);
    }

    /// Metrics of the steps added; all zero when there were none.
    pub(crate) fn metrics(&self, score: &Score) -> EpisodeMetrics {
        if self.steps == 0 {
            return EpisodeMetrics::default();
        }
        let (steps, uavs, pois) = (f64::from(self.steps), score.reward.len() as f64, score.steps_covered.len() as f64);
        EpisodeMetrics {
            coverage: self.covered as f64 / (steps * pois),
            coverage_last: score.covered as f64 / pois,
            energy: self.energy / (steps * uavs),
            individual: self.individual as f64 / (steps * uavs),
            group: self.group as f64 / (steps * uavs),
            reward: self.reward / uavs,
            fairness: jain(&score.steps_covered),
        }
    }
}

/// Jain's index of non-negative numbers, 0 when all are zero.
fn jain(times: &[u32]) -> f64 {
    let sum: f64 = times.iter().map(|&t| f64::from(t)).sum();
    let squares: f64 = times.iter().map(|&t| f64::from(t) * f64::from(t)).sum();
    if squares == 0.0 { 0.0 } else { sum * sum / (times.len() as f64 * squares) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jain_index_of_the_textbook_cases() {
        assert_eq!(jain(&[0, 0, 0]), 0.0);
        assert_eq!(jain(&[7, 7, 7, 7]), 1.0);
        assert_eq!(jain(&[5, 0, 0, 0]), 0.25);
        assert!((jain(&[1, 2, 3]) - 36.0 / 42.0).abs() < 1e-12);
    }

    #[test]
    fn values_and_names_line_up() {
        let m = EpisodeMetrics { coverage_last: 0.5, fairness: 0.25, ..EpisodeMetrics::default() };
        assert_eq!(EpisodeMetrics::from_values(m.values()), m);
        assert_eq!(EpisodeMetrics::NAMES[1], "coverage_last");
        assert_eq!(m.values()[6], 0.25);
    }
}
