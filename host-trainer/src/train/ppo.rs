//! The PPO loss and its gradient (paper, equations 8 and 12), sample by sample.
//!
//! The gradient with respect to logits and values is written out here; the networks carry
//! it back to their weights.

use super::softmax::{WIDTH, distribution, row_of, sum};
use covey_net::Rows;
use covey_net::exp;
use covey_net::kernel::{Vectorised, vectorised};

/// Numbers of the loss that come from the settings.
#[derive(Clone, Copy, Debug)]
pub struct Loss {
    /// Clip range of the ratio.
    pub clip: f32,
    /// Weight of the entropy bonus.
    pub entropy: f32,
    /// Error at which the value loss turns linear.
    pub huber: f32,
    /// Weight of the cross-entropy with the advised action.
    pub cloning_weight: f32,
    /// Samples in the whole minibatch: the loss is their mean.
    pub samples: f32,
}

/// One sample of the buffer.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Action taken.
    pub action: u8,
    /// Action that was advised; it counts with [`Loss::cloning_weight`].
    pub advice: u8,
    /// Its log-probability when it was taken.
    pub log_probability: f32,
    /// Normalised advantage.
    pub advantage: f32,
    /// Normalised return.
    pub target: f32,
}

/// Sums over samples, for the metrics.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Clipped surrogate, negated.
    pub policy_loss: f64,
    /// Value loss.
    pub value_loss: f64,
    /// Entropy.
    pub entropy: f64,
    /// Estimate of the KL divergence from the old policy: r − 1 − ln r.
    pub kl: f64,
    /// Samples whose ratio left the clip range.
    pub clipped: f64,
    /// Samples.
    pub samples: f64,
}

impl Sums {
    /// Adds those of another part.
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

impl Loss {
    /// Adds the samples' losses to `sums` and overwrites their logits and values by the
    /// gradient of the mean loss with respect to them.
    ///
    /// # Panics
    /// When rows and samples differ in number.
    pub fn backward(&self, logits: &mut Rows, values: &mut Rows, samples: &[Sample], sums: &mut Sums) {
        struct Backward<'a>(&'a Loss, &'a mut Rows, &'a mut Rows, &'a [Sample], &'a mut Sums);
        impl Vectorised for Backward<'_> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(loss, logits, values, samples, sums) = self;
                let value_step = values.step();
                let rows = logits.values_mut().chunks_exact_mut(WIDTH);
                let rows = rows.zip(values.values_mut().chunks_exact_mut(value_step));
                for ((logits, value), sample) in rows.zip(samples) {
                    let (by_logits, by_value) = loss.sample(row_of(logits), value[0], sample, sums);
                    logits.copy_from_slice(&by_logits);
                    value[0] = by_value;
                }
            }
        }
        assert!(logits.rows() == samples.len() && values.rows() == samples.len(), "a row a sample");
        vectorised(Backward(self, logits, values, samples, sums));
    }

    /// Adds a sample's loss to `sums`; returns the gradient of the mean loss with respect
    /// to its logits and its value.
    #[inline(always)]
    fn sample(&self, logits: &[f32; WIDTH], value: f32, s: &Sample, sums: &mut Sums) -> ([f32; WIDTH], f32) {
        let (log_p, p) = distribution(logits);
        let a = usize::from(s.action);
        let log_ratio = log_p[a] - s.log_probability;
        let ratio = exp(log_ratio);
        let clipped = ratio.clamp(1.0 - self.clip, 1.0 + self.clip);
        let surrogate = (ratio * s.advantage).min(clipped * s.advantage);
        // Where the clipped branch is the smaller one, it is constant.
        let pull = if ratio * s.advantage <= clipped * s.advantage { -ratio * s.advantage } else { 0.0 };
        let mut terms = p;
        terms.iter_mut().zip(&log_p).for_each(|(t, l)| *t *= l);
        let entropy = -sum(&terms);
        let scale = self.samples.recip();
        let mut by_logits = p;
        for (g, l) in by_logits.iter_mut().zip(&log_p) {
            *g *= scale * (self.entropy * (l + entropy) - pull + self.cloning_weight);
        }
        by_logits[a] += scale * pull;
        by_logits[usize::from(s.advice)] -= scale * self.cloning_weight;
        let error = value - s.target;
        let value_loss =
            if error.abs() <= self.huber { 0.5 * error * error } else { self.huber * (error.abs() - 0.5 * self.huber) };
        sums.add(&Sums {
            policy_loss: f64::from(-surrogate),
            value_loss: f64::from(value_loss),
            entropy: f64::from(entropy),
            kl: f64::from(ratio - 1.0 - log_ratio),
            clipped: f64::from(u8::from((ratio - 1.0).abs() > self.clip)),
            samples: 1.0,
        });
        (by_logits, error.clamp(-self.huber, self.huber) * scale)
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
            (action, advice) in (0u8..17, 0u8..17), advantage in -2.0f32..2.0, shift in -0.5f32..0.5,
            value in -3.0f32..3.0, target in -3.0f32..3.0,
        ) {
            let loss = Loss { clip: 0.2, entropy: 0.01, huber: 1.0, cloning_weight: 0.3, samples: 1.0 };
            let padded = |logits: &[f32; 17]| {
                let mut row = [0.0; WIDTH];
                row[..17].copy_from_slice(logits);
                row
            };
            let log_probability = distribution(&padded(&logits)).0[usize::from(action)] + shift;
            let s = Sample { action, advice, log_probability, advantage, target };
            let total = |l: &[f32; 17], v: f32| {
                let mut sums = Sums::default();
                loss.sample(&padded(l), v, &s, &mut sums);
                let advised = f64::from(distribution(&padded(l)).0[usize::from(advice)]);
                sums.policy_loss - 0.01 * sums.entropy + sums.value_loss - 0.3 * advised
            };
            // At the edge of the clip range the loss has a corner.
            prop_assume!(((-shift).exp() - 1.2).abs() > 0.02 && ((-shift).exp() - 0.8).abs() > 0.02);
            let (gradient, by_value) = loss.sample(&padded(&logits), value, &s, &mut Sums::default());
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
