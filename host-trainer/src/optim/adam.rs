//! Adam on a flat vector, with the gradient clipped by its global norm.

use covey_net::kernel::{Vectorised, vectorised};
use serde::{Deserialize, Serialize};

const BETA1: f32 = 0.9;
const BETA2: f32 = 0.999;
const EPSILON: f32 = 1e-5;

/// State of the optimiser (Kingma and Ba 2015, algorithm 1) of one parameter vector; β 0.9 and
/// 0.999, ε 10⁻⁵.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    first_moments: Vec<f32>,
    second_moments: Vec<f32>,
    steps: u64,
}

impl Adam {
    /// For `length` parameters, before the first step.
    #[must_use]
    pub fn new(length: usize) -> Self {
        Self { first_moments: vec![0.0; length], second_moments: vec![0.0; length], steps: 0 }
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.first_moments.len()
    }

    /// Whether there are no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.first_moments.is_empty()
    }

    /// One step of `parameters` against `gradient`, which is first clipped to the global norm
    /// `max_norm`. Returns the norm before that.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], learning_rate: f64, max_norm: f64) -> f64 {
        let norm = vectorised(SquareSum(gradient)).sqrt();
        let clip = (max_norm / (norm + 1e-6)).min(1.0) as f32;
        self.steps += 1;
        let correction = |beta: f32| 1.0 - f64::from(beta).powi(self.steps.min(i32::MAX as u64) as i32);
        let (c1, c2) = (correction(BETA1), correction(BETA2));
        let rate = (learning_rate * c2.sqrt() / c1) as f32;
        let epsilon = (f64::from(EPSILON) * c2.sqrt()) as f32;
        vectorised(Step { adam: self, parameters, gradient, clip, rate, epsilon });
        norm
    }
}

struct SquareSum<'a>(&'a [f32]);

impl Vectorised for SquareSum<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        // Eight sums, so that one need not wait for the other.
        let mut sums = [0.0; 8];
        for part in self.0.chunks(8) {
            sums.iter_mut().zip(part).for_each(|(s, &g)| *s += f64::from(g) * f64::from(g));
        }
        sums.iter().sum()
    }
}

struct Step<'a> {
    adam: &'a mut Adam,
    parameters: &'a mut [f32],
    gradient: &'a [f32],
    clip: f32,
    rate: f32,
    epsilon: f32,
}

impl Vectorised for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let moments = self.adam.first_moments.iter_mut().zip(&mut self.adam.second_moments);
        for ((v, &g), (m, s)) in self.parameters.iter_mut().zip(self.gradient).zip(moments) {
            let g = g * self.clip;
            *m += (1.0 - BETA1) * (g - *m);
            *s += (1.0 - BETA2) * (g * g - *s);
            *v -= self.rate * *m / (s.sqrt() + self.epsilon);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_step_has_the_length_of_the_learning_rate() {
        let (mut adam, mut v) = (Adam::new(2), vec![1.0, 1.0]);
        let norm = adam.step(&mut v, &[3.0, -4.0], 0.01, 1e9);
        assert!((norm - 5.0).abs() < 1e-9);
        assert!((v[0] - 0.99).abs() < 1e-5 && (v[1] - 1.01).abs() < 1e-5, "{v:?}");
    }

    #[test]
    fn finds_the_minimum_of_a_bowl() {
        let (mut adam, mut v) = (Adam::new(1), vec![5.0f32]);
        for _ in 0..2000 {
            let g = [2.0 * (v[0] - 1.0)];
            adam.step(&mut v, &g, 0.02, 0.5);
        }
        assert!((v[0] - 1.0).abs() < 1e-2, "{v:?}");
    }
}
