//! The policy's distribution: probabilities from logits, and drawing from them.

use covey_net::kernel::{Vectorised, padded, vectorised};
use covey_net::{Rows, exp, ln};
use firmware_core::action::{ACTIONS, Action};

/// Logits of a row in whole vectors.
pub const WIDTH: usize = padded(ACTIONS);

/// Log-probabilities and probabilities of a row of logits. Beyond the actions
/// probabilities are zero and the logarithms any finite numbers.
#[inline(always)]
pub fn distribution(row: &[f32; WIDTH]) -> ([f32; WIDTH], [f32; WIDTH]) {
    let mut logits = *row;
    logits[ACTIONS..].fill(row[0]);
    let top = fold(&logits, |a, b| if a > b { a } else { b });
    let mut weights = logits.map(|l| exp(l - top));
    weights[ACTIONS..].fill(0.0);
    let sum = fold(&weights, |a, b| a + b);
    let (shift, scale) = (top + ln(sum), sum.recip());
    (logits.map(|l| l - shift), weights.map(|w| w * scale))
}

/// All numbers of a row together, by vectors and then by halves.
#[inline(always)]
pub fn fold(row: &[f32; WIDTH], f: impl Fn(f32, f32) -> f32) -> f32 {
    let four: [f32; 4] = std::array::from_fn(|k| {
        let lane = |l: usize| f(f(row[l], row[8 + l]), row[16 + l]);
        f(lane(k), lane(k + 4))
    });
    f(f(four[0], four[2]), f(four[1], four[3]))
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

/// Draws an action for every row of logits; `draws` are uniform in 0 to 1. Returns the
/// actions with their log-probabilities.
pub fn sample(logits: &Rows, draws: &[f64], taken: impl FnMut(usize, Action, f32)) {
    struct Sample<'a, F>(&'a Rows, &'a [f64], F);
    impl<F: FnMut(usize, Action, f32)> Vectorised for Sample<'_, F> {
        type Output = ();
        #[inline(always)]
        fn call(mut self) {
            let rows = self.0.values().chunks_exact(WIDTH).zip(self.1);
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
