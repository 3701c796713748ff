//! What a UAV makes of its neighbours' features (paper, equations 5 to 7), in
//! integers. Weights are Q15; with at most 16 neighbours and the UAV itself a sum
//! stays below 17·2¹⁵·2⁷ < 2²⁷.

use super::feature::{Feature, MAX_DEGREE, MAX_FEATURE, NeighbourFeature};
use super::softmax::weight;

/// `round(2¹⁵/√d)` for d = 1..=17.
const INVERSE_ROOT: [i32; MAX_DEGREE as usize] =
    [32768, 23170, 18919, 16384, 14654, 13377, 12385, 11585, 10923, 10362, 9880, 9459, 9088, 8758, 8461, 8192, 7947];

fn inverse_root(degree: u8) -> i32 {
    let k = usize::from(degree.clamp(1, MAX_DEGREE)) - 1;
    INVERSE_ROOT.get(k).copied().unwrap_or(0)
}

fn add(sums: &mut [i32; MAX_FEATURE], values: &[i8], weight: i32) {
    for (sum, &h) in sums.iter_mut().zip(values) {
        *sum += weight * i32::from(h);
    }
}

/// GCN: `Σ_j h_j/√(d_i·d_j)` over the neighbours and the UAV itself, Q15.
pub(super) fn gcn<'f>(
    own: &Feature,
    degree: u8,
    neighbours: impl Iterator<Item = NeighbourFeature<'f>>,
) -> [i32; MAX_FEATURE] {
    let mut sums = [0; MAX_FEATURE];
    let root = inverse_root(degree);
    let edge = |d: u8| (root * inverse_root(d) + (1 << 14)) >> 15;
    add(&mut sums, &own.values, edge(degree));
    for n in neighbours {
        add(&mut sums, n.values, edge(n.degree));
    }
    sums
}

/// `LeakyReLU` with slope 0.2 (6554/2¹⁵).
fn leaky(score: i32) -> i32 {
    if score < 0 { (score * 6554 + (1 << 14)) >> 15 } else { score }
}

/// GAT: `Σ_j α_ij·h_j` with `α` the softmax of `LeakyReLU(s_i + t_j)` over the
/// neighbours and the UAV itself, Q15.
pub(super) fn gat<'f>(
    own: &Feature,
    neighbours: impl Iterator<Item = NeighbourFeature<'f>> + Clone,
) -> [i32; MAX_FEATURE] {
    let score = |attention_source: i16| leaky(i32::from(own.attention_destination) + i32::from(attention_source));
    let mine = score(own.attention_source);
    let top = neighbours.clone().map(|n| score(n.attention_source)).fold(mine, i32::max);
    // At most 17·2^16, at least 2^16: the greatest score weighs one.
    let total =
        neighbours.clone().map(|n| weight(top - score(n.attention_source))).fold(weight(top - mine), |a, w| a + w);
    // weight <= 2^16, so the shifted value fits u32.
    let share =
        |attention_source: i16| (((weight(top - score(attention_source)) << 15) + total / 2) / total.max(1)) as i32;
    let mut sums = [0; MAX_FEATURE];
    add(&mut sums, &own.values, share(own.attention_source));
    for n in neighbours {
        add(&mut sums, n.values, share(n.attention_source));
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_roots_are_rounded() {
        for d in 1..=MAX_DEGREE {
            let exact = libm::round(32_768.0 / libm::sqrt(f64::from(d))) as i32;
            assert_eq!(inverse_root(d), exact, "degree {d}");
        }
    }
}
