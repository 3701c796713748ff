//! Generalised advantage estimation and value normalisation.

use serde::{Deserialize, Serialize};

/// Advantages of one UAV over a rollout (Schulman et al. 2016, equation 16).
///
/// `rewards` and `advantages` are by step, `values` has one entry more: the value of
/// the state after the rollout.
pub fn advantages(rewards: &[f32], values: &[f32], gamma: f32, lambda: f32, advantages: &mut [f32]) {
    let mut ahead = 0.0;
    for t in (0..rewards.len()).rev() {
        let error = rewards[t] + gamma * values[t + 1] - values[t];
        ahead = error + gamma * lambda * ahead;
        advantages[t] = ahead;
    }
}

/// Running mean and deviation of returns: the critic learns `(return − mean)/deviation`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueNorm {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    started: bool,
}

impl Default for ValueNorm {
    fn default() -> Self {
        Self { mean: 0.0, deviation: 1.0, started: false }
    }
}

impl ValueNorm {
    /// Takes in the mean and deviation of a new batch of returns; `decay` is the share
    /// of the old ones that stays.
    pub fn update(&mut self, mean: f64, deviation: f64, decay: f64) {
        let keep = if self.started { decay } else { 0.0 };
        self.mean = keep * self.mean + (1.0 - keep) * mean;
        self.deviation = keep * self.deviation + (1.0 - keep) * deviation.max(1e-3);
        self.started = true;
    }

    /// A value in reward units from the critic's output.
    #[must_use]
    pub fn restore(&self, v: f32) -> f32 {
        (f64::from(v) * self.deviation + self.mean) as f32
    }

    /// The critic's target for a return.
    #[must_use]
    pub fn normalise(&self, v: f32) -> f32 {
        ((f64::from(v) - self.mean) / self.deviation) as f32
    }
}

/// Mean and standard deviation.
#[must_use]
pub fn moments(values: &[f32]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
    let variance = values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_gamma_and_lambda_one_it_is_the_plain_return() {
        let (r, v) = ([1.0, 2.0, 3.0], [0.5, -1.0, 2.0, 0.0]);
        let mut a = [0.0; 3];
        advantages(&r, &v, 1.0, 1.0, &mut a);
        let returns: Vec<f32> = a.iter().zip(v).map(|(a, v)| a + v).collect();
        assert_eq!(returns, [6.0, 5.0, 3.0]);
    }

    #[test]
    fn with_lambda_zero_it_is_the_one_step_error() {
        let mut a = [0.0; 2];
        advantages(&[1.0, 2.0], &[0.0, 4.0, 8.0], 0.5, 0.0, &mut a);
        assert_eq!(a, [3.0, 2.0]);
    }

    #[test]
    fn normalisation_inverts() {
        let mut n = ValueNorm::default();
        n.update(10.0, 4.0, 0.9);
        assert_eq!((n.mean, n.deviation), (10.0, 4.0));
        n.update(20.0, 4.0, 0.9);
        assert!((n.mean - 11.0).abs() < 1e-9);
        assert!((n.restore(n.normalise(7.0)) - 7.0).abs() < 1e-5);
    }
}
