//! The result of an evaluation: means over worlds and their standard errors.

use crate::world::EpisodeMetrics;

/// The metrics of a policy on held-out worlds.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Metrics of each world, in the order of their indices.
    pub worlds: Vec<EpisodeMetrics>,
}

impl Evaluation {
    /// Mean over worlds of each metric; NaN when there are no worlds.
    #[must_use]
    pub fn mean(&self) -> EpisodeMetrics {
        let n = self.worlds.len() as f64;
        EpisodeMetrics::from_values(self.sums(|v, _| v).map(|s| s / n))
    }

    /// Standard error of each mean: the sample standard deviation over worlds / √worlds. NaN for fewer than two
    /// worlds.
    #[must_use]
    pub fn standard_error(&self) -> EpisodeMetrics {
        let n = self.worlds.len() as f64;
        let squares = self.sums(|v, mean| (v - mean) * (v - mean));
        EpisodeMetrics::from_values(squares.map(|s| (s / (n - 1.0) / n).sqrt()))
    }

    /// Sums `f(value, mean)` over worlds, for each metric.
    fn sums(&self, f: impl Fn(f64, f64) -> f64) -> [f64; 7] {
        let n = self.worlds.len() as f64;
        let add = |mut a: [f64; 7], v: [f64; 7]| {
            a.iter_mut().zip(v).for_each(|(a, v)| *a += v);
            a
        };
        let values = || self.worlds.iter().map(EpisodeMetrics::values);
        let mean = values().fold([0.0; 7], add).map(|s| s / n);
        values().map(|v| std::array::from_fn(|k| f(v[k], mean[k]))).fold([0.0; 7], add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_error() {
        let world = |coverage| EpisodeMetrics { coverage, ..EpisodeMetrics::default() };
        let e = Evaluation { worlds: vec![world(1.0), world(2.0), world(3.0), world(4.0)] };
        assert_eq!(e.mean().coverage, 2.5);
        assert!((e.standard_error().coverage - (5.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
        assert_eq!(e.standard_error().energy, 0.0);
    }
}
