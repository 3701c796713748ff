//! The policy's distribution: probabilities from logits, and drawing from them.

use covey_net::kernel::{LANES, Vectorised, padded, vectorised};
use covey_net::{exp, ln};
use firmware_core::action::{ACTIONS, Action};

/// Logits of a row in whole vectors.
pub const WIDTH: usize = padded(ACTIONS);

/// Log-probabilities and probabilities of a row of logits. Beyond the actions
/// probabilities are zero and the logarithms any finite numbers.
// Plain loops: closures of `map` and `from_fn` are not always inlined, see `Vectorised`.
#[inline(always)]
pub fn distribution(row: &[f32; WIDTH]) -> ([f32; WIDTH], [f32; WIDTH]) {
    let mut log_p = *row;
    log_p[ACTIONS..].fill(row[0]);
    let mut tops = [f32::NEG_INFINITY; LANES];
    for part in log_p.chunks_exact(LANES) {
        tops.iter_mut().zip(part).for_each(|(t, &l)| *t = if l > *t { l } else { *t });
    }
    let top = tops.iter().fold(tops[0], |a, &b| if b > a { b } else { a });
    let mut p = [0.0; WIDTH];
    p.iter_mut().zip(&log_p).for_each(|(p, l)| *p = exp(l - top));
    p[ACTIONS..].fill(0.0);
    let sum = sum(&p);
    let (shift, scale) = (top + ln(sum), sum.recip());
    log_p.iter_mut().for_each(|l| *l -= shift);
    p.iter_mut().for_each(|p| *p *= scale);
    (log_p, p)
}

/// Sum of a row, by vectors and then by halves.
#[inline(always)]
pub fn sum(row: &[f32; WIDTH]) -> f32 {
    let mut sums = [0.0; LANES];
    for part in row.chunks_exact(LANES) {
        sums.iter_mut().zip(part).for_each(|(s, v)| *s += v);
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// A row of logits with its padding.
///
/// # Panics
/// When it is shorter than the padded row.
#[inline(always)]
pub fn row_of(values: &[f32]) -> &[f32; WIDTH] {
    values[..WIDTH].try_into().expect("a padded row of logits")
}

/// The action in which `draw`, 0 to 1, of the probability falls.
#[inline(always)]
fn pick(probabilities: &[f32; WIDTH], draw: f64) -> usize {
    let mut left = draw;
    for (action, p) in probabilities[..ACTIONS].iter().enumerate() {
        left -= f64::from(*p);
        if left < 0.0 {
            return action;
        }
    }
    usize::from(Action::COAST.index())
}

/// Draws an action for every row of logits, padded as in [`Rows`](covey_net::Rows); `draws` are
/// uniform in 0 to 1. Hands out the actions with their log-probabilities.
pub fn sample(logits: &[f32], draws: &[f64], taken: impl FnMut(usize, Action, f32)) {
    struct Sample<'a, F>(&'a [f32], &'a [f64], F);
    impl<F: FnMut(usize, Action, f32)> Vectorised for Sample<'_, F> {
        type Output = ();
        #[inline(always)]
        fn call(mut self) {
            let rows = self.0.chunks_exact(WIDTH).zip(self.1);
            for (k, (row, &draw)) in rows.enumerate() {
                let (log_p, p) = distribution(row_of(row));
                let action = pick(&p, draw);
                self.2(k, Action::new(action as u8).unwrap_or(Action::COAST), log_p[action]);
            }
        }
    }
    vectorised(Sample(logits, draws, taken));
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn probabilities_are_the_softmax(logits in proptest::array::uniform17(-30.0f32..30.0), draw in 0.0f64..1.0) {
            let mut row = [f32::NAN; WIDTH];
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
            let action = pick(&p, draw);
            let below: f64 = exact[..action].iter().map(|e| e.exp()).sum();
            prop_assert!(draw > below - 1e-5 && draw < below + exact[action].exp() + 1e-5);
        }
    }
}
