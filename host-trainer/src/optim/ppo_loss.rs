//! The PPO loss and its gradient (paper, equations 8 and 12), sample by sample.
//!
//! The gradient with respect to logits and values is written out here; the networks carry
//! it back to their weights.

use crate::rollout::{PADDED_ACTIONS, distribution, padded_row, sum};
use covey_net::Rows;
use covey_net::exp;
use covey_net::kernel::{Vectorised, vectorised};

/// The coefficients of the loss
/// `−min(ρ A, clamp(ρ, 1 ± clip) A) − entropy_coef · H + Huber(V − target) + cloning_weight · CE`:
/// ρ is the ratio of the new to the old probability of the action, A the normalised advantage, H
/// the policy's entropy and CE its cross-entropy with the expert's action.
#[derive(Clone, Copy, Debug)]
pub struct PpoLoss {
    /// Clip range of the ratio.
    pub clip_range: f32,
    /// Weight of the entropy bonus.
    pub entropy_coef: f32,
    /// Error, in standard deviations of the return, beyond which the value loss is linear.
    pub huber_delta: f32,
    /// Weight of the cross-entropy with the expert's action: of behaviour cloning.
    pub cloning_weight: f32,
}

/// One UAV at one step of a rollout, as the loss takes it.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Index of the action taken.
    pub action: u8,
    /// Index of the expert's action; it counts with [`PpoLoss::cloning_weight`].
    pub expert_action: u8,
    /// Log-probability of the action taken, when it was taken.
    pub log_prob: f32,
    /// Normalised advantage.
    pub advantage: f32,
    /// Normalised return.
    pub target: f32,
}

/// Terms of the loss summed over samples, for the metrics.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LossSums {
    /// Clipped surrogate, negated.
    pub policy_loss: f64,
    /// Value loss.
    pub value_loss: f64,
    /// Entropy of the policy, nats.
    pub entropy: f64,
    /// Estimate of the KL divergence from the old policy, nats: ρ − 1 − ln ρ.
    pub kl: f64,
    /// Number of samples whose ratio left the clip range.
    pub clipped: f64,
    /// Number of samples.
    pub samples: f64,
}

impl LossSums {
    /// Adds those of other samples.
    #[inline(always)]
    pub fn add(&mut self, o: &Self) {
        self.policy_loss += o.policy_loss;
        self.value_loss += o.value_loss;
        self.entropy += o.entropy;
        self.kl += o.kl;
        self.clipped += o.clipped;
        self.samples += o.samples;
    }
}

impl PpoLoss {
    /// Adds the samples' losses to `sums` and overwrites their logits (17 wide) and values (1
    /// wide) by the gradient with respect to them of the mean loss over a minibatch of
    /// `minibatch` samples, of which these are some.
    ///
    /// # Panics
    /// When rows and samples differ in number.
    pub fn backward(
        &self,
        logits: &mut Rows,
        values: &mut Rows,
        samples: &[Sample],
        minibatch: usize,
        sums: &mut LossSums,
    ) {
        struct Backward<'a>(&'a PpoLoss, f32, &'a mut Rows, &'a mut Rows, &'a [Sample], &'a mut LossSums);
        impl Vectorised for Backward<'_> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(loss, scale, logits, values, samples, sums) = self;
                let value_stride = values.stride();
                let rows = logits.values_mut().chunks_exact_mut(PADDED_ACTIONS);
                let rows = rows.zip(values.values_mut().chunks_exact_mut(value_stride));
                for ((logits, value), sample) in rows.zip(samples) {
                    let (by_logits, by_value) = loss.sample(padded_row(logits), value[0], sample, scale, sums);
                    logits.copy_from_slice(&by_logits);
                    value[0] = by_value;
                }
            }
        }
        assert!(logits.rows() == samples.len() && values.rows() == samples.len(), "a row a sample");
        vectorised(Backward(self, (minibatch as f32).recip(), logits, values, samples, sums));
    }

    /// Adds a sample's loss to `sums`; returns `scale` times its gradient with respect to its
    /// logits and its value.
    #[inline(always)]
    fn sample(
        &self,
        logits: &[f32; PADDED_ACTIONS],
        value: f32,
        s: &Sample,
        scale: f32,
        sums: &mut LossSums,
    ) -> ([f32; PADDED_ACTIONS], f32) {
        let (log_p, p) = distribution(logits);
        let a = usize::from(s.action);
        let log_ratio = log_p[a] - s.log_prob;
        let ratio = exp(log_ratio);
        let clipped = ratio.clamp(1.0 - self.clip_range, 1.0 + self.clip_range);
        let surrogate = (ratio * s.advantage).min(clipped * s.advantage);
        // Gradient of −surrogate by the log-probability. Where the clipped branch is the smaller one, it is constant.
        let by_log_prob = if ratio * s.advantage <= clipped * s.advantage { -ratio * s.advantage } else { 0.0 };
        let mut terms = p;
        terms.iter_mut().zip(&log_p).for_each(|(t, l)| *t *= l);
        let entropy = -sum(&terms);
        let mut by_logits = p;
        for (g, l) in by_logits.iter_mut().zip(&log_p) {
            *g *= scale * (self.entropy_coef * (l + entropy) - by_log_prob + self.cloning_weight);
        }
        by_logits[a] += scale * by_log_prob;
        by_logits[usize::from(s.expert_action)] -= scale * self.cloning_weight;
        let error = value - s.target;
        let value_loss = if error.abs() <= self.huber_delta {
            0.5 * error * error
        } else {
            self.huber_delta * (error.abs() - 0.5 * self.huber_delta)
        };
        sums.add(&LossSums {
            policy_loss: f64::from(-surrogate),
            value_loss: f64::from(value_loss),
            entropy: f64::from(entropy),
            kl: f64::from(ratio - 1.0 - log_ratio),
            clipped: f64::from(u8::from((ratio - 1.0).abs() > self.clip_range)),
            samples: 1.0,
        });
        (by_logits, error.clamp(-self.huber_delta, self.huber_delta) * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The written-out gradient is the slope of the loss.
        #[test]
        fn gradient_is_the_slope(
            logits in proptest::array::uniform17(-3.0f32..3.0),
            (action, expert_action) in (0u8..17, 0u8..17), advantage in -2.0f32..2.0, shift in -0.5f32..0.5,
            value in -3.0f32..3.0, target in -3.0f32..3.0,
        ) {
            let loss = PpoLoss { clip_range: 0.2, entropy_coef: 0.01, huber_delta: 1.0, cloning_weight: 0.3 };
            let padded = |logits: &[f32; 17]| {
                let mut row = [0.0; PADDED_ACTIONS];
                row[..17].copy_from_slice(logits);
                row
            };
            let log_prob = distribution(&padded(&logits)).0[usize::from(action)] + shift;
            let s = Sample { action, expert_action, log_prob, advantage, target };
            let total = |l: &[f32; 17], v: f32| {
                let mut sums = LossSums::default();
                loss.sample(&padded(l), v, &s, 1.0, &mut sums);
                let expert_log_prob = f64::from(distribution(&padded(l)).0[usize::from(expert_action)]);
                sums.policy_loss - 0.01 * sums.entropy + sums.value_loss - 0.3 * expert_log_prob
            };
            // At the edge of the clip range the loss has a corner.
            prop_assume!(((-shift).exp() - 1.2).abs() > 0.02 && ((-shift).exp() - 0.8).abs() > 0.02);
            let (gradient, by_value) = loss.sample(&padded(&logits), value, &s, 1.0, &mut LossSums::default());
            prop_assert!(gradient[17..].iter().all(|&g| g == 0.0));
            let h = 3e-3f32;
            for k in 0..17 {
                let (mut up, mut down) = (logits, logits);
                up[k] += h;
                down[k] -= h;
                let slope = (total(&up, value) - total(&down, value)) / f64::from(2.0 * h);
                prop_assert!((slope - f64::from(gradient[k])).abs() < 2e-3, "{k}: {slope} {}", gradient[k]);
            }
            let slope = (total(&logits, value + h) - total(&logits, value - h)) / f64::from(2.0 * h);
            prop_assert!((slope - f64::from(by_value)).abs() < 3e-3, "value: {slope} {by_value}");
        }
    }
}
