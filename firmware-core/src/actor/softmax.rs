//! Integer softmax: powers of two from a table, in fixed point.
//!
//! Scores are in 1/256 of a doubling (Q8 of log₂): a difference of 256 halves the
//! weight. Weights are Q16.

use crate::action::{ACTIONS, Action};

/// Fraction bits of scores and logits.
pub const SCORE_BITS: u32 = 8;

/// `round(2^(16 − k/256))` for k in 0..256.
static EXP2: [u32; 256] = {
    // 2^(-1/256) in Q62, multiplied up: the error after 255 products stays far
    // below half a unit of Q16.
    let mut table = [0u32; 256];
    let root: u128 = 4_599_216_278_082_138_665; // round(2^62 · 2^(-1/256))
    let mut value: u128 = 1 << 62;
    let mut k = 0;
    while k < 256 {
        table[k] = ((value + (1 << 45)) >> 46) as u32;
        value = (value * root) >> 62;
        k += 1;
    }
    table
};

/// `2^(−below/256)` in Q16 for a score that lies `below` ≥ 0 under the greatest.
#[inline]
#[must_use]
pub fn weight(below: i32) -> u32 {
    let below = below.max(0) as u32;
    let whole = below >> SCORE_BITS;
    let fraction = (below & 0xff) as usize;
    match EXP2.get(fraction) {
        Some(w) if whole < 32 => w >> whole,
        _ => 0,
    }
}

/// The 17 logits of a decision, in units of 1/256 of a doubling.
pub type Logits = [i16; ACTIONS];

/// How an action is taken from the logits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// In proportion to the softmax weights.
    Sample,
    /// The greatest logit; of equal ones the first.
    Argmax,
}

/// The action with the greatest logit; of equal ones the first.
#[must_use]
pub fn argmax(logits: &Logits) -> Action {
    let mut best = (i16::MIN, Action::COAST);
    for (action, &l) in Action::all().zip(logits) {
        if l > best.0 {
            best = (l, action);
        }
    }
    best.1
}

/// The action that a uniform 32-bit `draw` picks: the weights laid end to end, the
/// one in which `draw/2³²` of their sum falls.
#[must_use]
pub fn sample(logits: &Logits, draw: u32) -> Action {
    let top = i32::from(logits.iter().copied().max().unwrap_or(0));
    let mut total = 0u32; // at most 17·2^16
    for &l in logits {
        total += weight(top - i32::from(l));
    }
    let mut left = ((u64::from(draw) * u64::from(total)) >> 32) as u32;
    for (action, &l) in Action::all().zip(logits) {
        let w = weight(top - i32::from(l));
        if left < w {
            return action;
        }
        left -= w;
    }
    Action::COAST // Not reached: `left` starts below the sum of the weights.
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_rounded_power_of_two() {
        for (k, &t) in EXP2.iter().enumerate() {
            let exact = libm::exp2(16.0 - k as f64 / 256.0);
            assert_eq!(t, libm::round(exact) as u32, "k = {k}");
        }
        assert_eq!(weight(0), 65_536);
        assert_eq!(weight(256), 32_768);
        assert_eq!(weight(i32::MAX), 0);
    }

    #[test]
    fn sampling_follows_the_weights() {
        let mut logits = [-9000i16; ACTIONS];
        (logits[3], logits[9]) = (512, 256); // weights 2 : 1, the rest nothing
        let n = 30_000u32;
        let hits = (0..n).filter(|k| sample(&logits, k * (u32::MAX / n)).index() == 3).count();
        assert!((f64::from(hits as u32) / f64::from(n) - 2.0 / 3.0).abs() < 0.005, "{hits}");
        assert_eq!(sample(&logits, 0).index(), 3);
        assert_eq!(sample(&logits, u32::MAX).index(), 9);
        assert_eq!(argmax(&logits).index(), 3);
        assert_eq!(argmax(&[7; ACTIONS]).index(), 0);
    }
}
