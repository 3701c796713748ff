//! Normalisation of returns: the critic learns values of mean 0 and deviation 1.

use serde::{Deserialize, Serialize};

/// Running mean and standard deviation of returns, in units of reward. The critic's output is
/// `(return − mean)/deviation`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueNorm {
    /// Mean of returns.
    pub mean: f64,
    /// Standard deviation of returns, at least 0.001.
    pub deviation: f64,
    started: bool,
}

impl Default for ValueNorm {
    fn default() -> Self {
        Self { mean: 0.0, deviation: 1.0, started: false }
    }
}

impl ValueNorm {
    /// Takes in the mean and standard deviation of a new batch of returns; `decay` is the share
    /// of the old statistics that stays. The first batch replaces the initial values altogether.
    pub fn update(&mut self, mean: f64, deviation: f64, decay: f64) {
        let keep = if self.started { decay } else { 0.0 };
        self.mean = keep * self.mean + (1.0 - keep) * mean;
        self.deviation = keep * self.deviation + (1.0 - keep) * deviation.max(1e-3);
        self.started = true;
    }

    /// A value in units of reward from the critic's output.
    #[must_use]
    pub fn denormalise(&self, output: f32) -> f32 {
        (f64::from(output) * self.deviation + self.mean) as f32
    }

    /// The critic's target for a return in units of reward.
    #[must_use]
    pub fn normalise(&self, return_: f32) -> f32 {
        ((f64::from(return_) - self.mean) / self.deviation) as f32
    }
}

/// Mean and (population) standard deviation; zeros for no values.
#[must_use]
pub fn mean_and_deviation(values: &[f32]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
    let variance = values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalisation_inverts() {
        let mut n = ValueNorm::default();
        n.update(10.0, 4.0, 0.9);
        assert_eq!((n.mean, n.deviation), (10.0, 4.0));
        n.update(20.0, 4.0, 0.9);
        assert!((n.mean - 11.0).abs() < 1e-9);
        assert!((n.denormalise(n.normalise(7.0)) - 7.0).abs() < 1e-5);
    }
}
