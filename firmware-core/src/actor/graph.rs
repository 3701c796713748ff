//! What a UAV makes of its neighbours' features (paper, equations 5 to 7), in
//! integers. Weights are Q15; with at most 16 neighbours and the UAV itself a sum
//! stays below 17·2¹⁵·2⁷ < 2²⁷. Sums are added in place, to the caller's zeros: a board's stack
//! has room for one array of them.

use super::feature::{Feature, MAX_DEGREE, MAX_FEATURE, NeighbourFeature};
use super::layer::Row;
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
pub(super) fn gcn(sums: &mut [i32; MAX_FEATURE], own: &Feature, degree: u8, neighbours: &[NeighbourFeature<'_>]) {
    let root = inverse_root(degree);
    let edge = |d: u8| (root * inverse_root(d) + (1 << 14)) >> 15;
    add(sums, &own.values, edge(degree));
    for n in neighbours {
        add(sums, n.values, edge(n.degree));
    }
}

/// `GraphSAGE`: the mean of the neighbours' `h`, Q15; zeros when there are none.
pub(super) fn mean(sums: &mut [i32; MAX_FEATURE], neighbours: &[NeighbourFeature<'_>]) {
    let count = neighbours.len().clamp(1, usize::from(MAX_DEGREE)) as i32;
    let share = ((1 << 15) + count / 2) / count;
    for n in neighbours {
        add(sums, n.values, share);
    }
}

/// `LeakyReLU` with slope 0.2 (6554/2¹⁵).
fn leaky(score: i32) -> i32 {
    if score < 0 { (score * 6554 + (1 << 14)) >> 15 } else { score }
}

/// GAT: `Σ_j α_ij·h_j` with `α` the softmax of `LeakyReLU(s_i + t_j)` over the
/// neighbours and the UAV itself, Q15.
pub(super) fn gat(sums: &mut [i32; MAX_FEATURE], own: &Feature, neighbours: &[NeighbourFeature<'_>]) {
    let score = |attention_source: i16| leaky(i32::from(own.attention_destination) + i32::from(attention_source));
    attend(sums, own, score(own.attention_source), neighbours, |n| score(n.attention_source))
}

/// GATv2: greatest magnitude of a number of `W_l h`, four times that of a broadcast one, as it
/// need not fit into a byte.
pub const RECEIVER_MAX: i16 = 511;

/// GATv2: `Σ_j α_ij·r_j` with `α` the softmax of `aᵀ LeakyReLU(l_i + r_j)` over the neighbours
/// and the UAV itself, Q15, where `l = W_l h` and the broadcast `r = W_r h` have the same units.
pub(super) fn gatv2(
    sums: &mut [i32; MAX_FEATURE],
    own: &Feature,
    receiver: &[i16],
    attention: Row<'_>,
    neighbours: &[NeighbourFeature<'_>],
) {
    // Five times LeakyReLU with slope 1/5 is a whole number: up to 5·(511 + 127), or 639 below
    // zero; so a sum stays within 64·2⁷·3190 < 2²⁵, as much as a layer's.
    let score = |values: &[i8]| {
        let mut sum = 0;
        for ((&l, &r), a) in receiver.iter().zip(values).zip(attention.weights()) {
            let x = i32::from(l) + i32::from(r);
            sum += i32::from(a) * if x < 0 { x } else { 5 * x };
        }
        attention.wide(sum)
    };
    attend(sums, own, score(&own.values), neighbours, |n| score(n.values))
}

/// `Σ_j α_ij·values_j` with `α` the softmax of these scores, Q15. At most the first 16
/// neighbours count. `mine` is the score of the UAV itself.
#[inline]
fn attend(
    sums: &mut [i32; MAX_FEATURE],
    own: &Feature,
    mine: i32,
    neighbours: &[NeighbourFeature<'_>],
    score: impl Fn(&NeighbourFeature<'_>) -> i32,
) {
    // Scores, then weights.
    let mut theirs = [0; MAX_DEGREE as usize - 1];
    let mut top = mine;
    for (s, n) in theirs.iter_mut().zip(neighbours) {
        *s = score(n);
        top = top.max(*s);
    }
    let mine = weight(top - mine);
    // At most 17·2^16, at least 2^16: the greatest score weighs one.
    let mut total = mine;
    for (s, _) in theirs.iter_mut().zip(neighbours) {
        *s = weight(top - *s) as i32;
        total += *s as u32;
    }
    // weight <= 2^16, so the shifted value fits u32.
    let share = |weight: u32| (((weight << 15) + total / 2) / total.max(1)) as i32;
    add(sums, &own.values, share(mine));
    for (&w, n) in theirs.iter().zip(neighbours) {
        add(sums, n.values, share(w as u32));
    }
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

    #[test]
    fn a_mean_is_of_the_neighbours_alone() {
        let (some, others) = ([100i8; 2], [-20i8; 2]);
        let heard = |values| NeighbourFeature { values, degree: 3, attention_source: 0 };
        let mean = |neighbours: &[_]| {
            let mut sums = [0; MAX_FEATURE];
            mean(&mut sums, neighbours);
            sums
        };
        assert_eq!(mean(&[]), [0; MAX_FEATURE]);
        assert_eq!(mean(&[heard(&some)])[..3], [100 << 15, 100 << 15, 0]);
        // round(2¹⁵/3) = 10,923.
        assert_eq!(mean(&[heard(&some), heard(&some), heard(&others)])[..2], [180 * 10_923; 2]);
        assert_eq!(mean(&[heard(&others); 16])[..2], [-(20 << 15); 2]);
    }
}
