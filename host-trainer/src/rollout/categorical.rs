//! The policy's categorical distribution: probabilities from logits, and sampling.

use covey_net::kernel::{LANES, Vectorised, padded, vectorised};
use covey_net::{exp, ln};
use firmware_core::action::{ACTIONS, Action};

/// Numbers in a row of logits with its padding: actions in whole vectors of the kernel.
pub const PADDED_ACTIONS: usize = padded(ACTIONS);

/// Log-probabilities (log-softmax) and probabilities (softmax) of a row of logits. In the padding
/// probabilities are zero and their logarithms any finite numbers.
// Plain loops: closures of `map` and `from_fn` are not always inlined, see `Vectorised`.
#[inline(always)]
pub fn distribution(row: &[f32; PADDED_ACTIONS]) -> ([f32; PADDED_ACTIONS], [f32; PADDED_ACTIONS]) {
    let mut log_p = *row;
    log_p[ACTIONS..].fill(row[0]);
    let mut maxima = [f32::NEG_INFINITY; LANES];
    for lanes in log_p.chunks_exact(LANES) {
        maxima.iter_mut().zip(lanes).for_each(|(m, &l)| *m = if l > *m { l } else { *m });
    }
    let max = maxima.iter().fold(maxima[0], |a, &b| if b > a { b } else { a });
    let mut p = [0.0; PADDED_ACTIONS];
    p.iter_mut().zip(&log_p).for_each(|(p, l)| *p = exp(l - max));
    p[ACTIONS..].fill(0.0);
    let sum = sum(&p);
    let (shift, scale) = (max + ln(sum), sum.recip());
    log_p.iter_mut().for_each(|l| *l -= shift);
    p.iter_mut().for_each(|p| *p *= scale);
    (log_p, p)
}

/// Sum of a padded row: by vectors, then by halves, so that it vectorises.
#[inline(always)]
pub fn sum(row: &[f32; PADDED_ACTIONS]) -> f32 {
    let mut sums = [0.0; LANES];
    for lanes in row.chunks_exact(LANES) {
        sums.iter_mut().zip(lanes).for_each(|(s, v)| *s += v);
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// A row of logits with its padding.
///
/// # Panics
/// When it is shorter than the padded row.
#[inline(always)]
pub fn padded_row(values: &[f32]) -> &[f32; PADDED_ACTIONS] {
    values[..PADDED_ACTIONS].try_into().expect("a padded row of logits")
}

/// The first action up to which the probabilities sum to more than `draw`, which is uniform in 0
/// to 1.
#[inline(always)]
fn invert_cdf(probabilities: &[f32; PADDED_ACTIONS], draw: f64) -> usize {
    let mut left = draw;
    for (action, p) in probabilities[..ACTIONS].iter().enumerate() {
        left -= f64::from(*p);
        if left < 0.0 {
            return action;
        }
    }
    usize::from(Action::COAST.index())
}

/// Samples an action for every row of logits, padded as in [`Rows`](covey_net::Rows), by one of
/// `draws` each, which are uniform in 0 to 1. Calls `take` with each row's number, action and
/// log-probability.
pub fn sample(logits: &[f32], draws: &[f64], take: impl FnMut(usize, Action, f32)) {
    struct Sample<'a, F>(&'a [f32], &'a [f64], F);
    impl<F: FnMut(usize, Action, f32)> Vectorised for Sample<'_, F> {
        type Output = ();
        #[inline(always)]
        fn call(mut self) {
            let rows = self.0.chunks_exact(PADDED_ACTIONS).zip(self.1);
            for (k, (row, &draw)) in rows.enumerate() {
                let (log_p, p) = distribution(padded_row(row));
                let action = invert_cdf(&p, draw);
                self.2(k, Action::new(action as u8).unwrap_or(Action::COAST), log_p[action]);
            }
        }
    }
    vectorised(Sample(logits, draws, take));
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn probabilities_are_the_softmax(logits in proptest::array::uniform17(-30.0f32..30.0), draw in 0.0f64..1.0) {
            let mut row = [f32::NAN; PADDED_ACTIONS];
            row[..ACTIONS].copy_from_slice(&logits);
            let (log_p, p) = distribution(&row);
            let sum: f64 = logits.iter().map(|&l| f64::from(l).exp()).sum();
            let exact: Vec<f64> = logits.iter().map(|&l| f64::from(l) - sum.ln()).collect();
            for (k, e) in exact.iter().enumerate() {
                prop_assert!((f64::from(log_p[k]) - e).abs() < 1e-5, "{k}: {} {e}", log_p[k]);
                prop_assert!((f64::from(p[k]) - e.exp()).abs() < 1e-6, "{k}: {} {e}", p[k]);
            }
            prop_assert!(p[ACTIONS..].iter().all(|&p| p == 0.0));
            // The draw falls into its action's share.
            let action = invert_cdf(&p, draw);
            let below: f64 = exact[..action].iter().map(|e| e.exp()).sum();
            prop_assert!(draw > below - 1e-5 && draw < below + exact[action].exp() + 1e-5);
        }
    }
}
