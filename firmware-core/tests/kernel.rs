//! The dense kernel against the sum as one would write it down, at random and at the extremes.

use firmware_core::kernel::{Dense, Finish, MAX_COLUMNS, WIDE_SHIFT, pack, portable};
use proptest::collection::vec;
use proptest::prelude::*;

/// A layer as plain numbers, row-major.
#[derive(Clone, Debug)]
struct Plain {
    columns: usize,
    weights: Vec<i8>,
    biases: Vec<i32>,
    multipliers: Vec<i32>,
}

impl Plain {
    fn filled(rows: usize, columns: usize, weight: i8, multiplier: i32) -> Self {
        Self {
            columns,
            weights: vec![weight; rows * columns],
            biases: vec![0; rows],
            multipliers: vec![multiplier; rows],
        }
    }

    fn rows(&self) -> usize {
        self.biases.len()
    }

    /// As in the actor file.
    fn packed(&self) -> Vec<u8> {
        let weight = |row: usize, column: usize| {
            if row < self.rows() && column < self.columns { self.weights[row * self.columns + column] } else { 0 }
        };
        let pairs = (0..self.rows()).step_by(2);
        pairs
            .flat_map(|a| (0..self.columns.next_multiple_of(2)).map(move |column| (a, column)))
            .flat_map(|(a, column)| pack(weight(a, column), weight(a + 1, column)))
            .collect()
    }

    /// The outputs in 64-bit arithmetic, where nothing can wrap.
    fn expected(&self, x: &[i8], finish: Finish) -> Vec<i16> {
        let rows = self.weights.chunks(self.columns).zip(&self.biases).zip(&self.multipliers);
        rows.map(|((weights, &bias), &multiplier)| {
            let sum = i64::from(bias) + weights.iter().zip(x).map(|(&w, &x)| i64::from(w) * i64::from(x)).sum::<i64>();
            let (sum, low, high) = match finish {
                Finish::Rectified => (sum, 0, 127),
                Finish::Wide => (sum << WIDE_SHIFT, i16::MIN.into(), i16::MAX.into()),
            };
            let rounded = (i128::from(sum) * i128::from(multiplier) + (1 << 31)) >> 32;
            rounded.clamp(low, high) as i16
        })
        .collect()
    }

    /// What `apply` makes of it, with one place more than it may touch.
    fn outputs(&self, x: &[i8], finish: Finish, apply: impl Fn(&Dense<'_>, &[i16], &mut [i16], Finish)) -> Vec<i16> {
        let weights = self.packed();
        let bytes = |words: &[i32]| -> Vec<[u8; 4]> { words.iter().map(|word| word.to_le_bytes()).collect() };
        let (biases, multipliers) = (bytes(&self.biases), bytes(&self.multipliers));
        let layer = Dense { weights: &weights, biases: &biases, multipliers: &multipliers };
        let mut input: Vec<i16> = x.iter().map(|&x| x.into()).collect();
        input.resize(self.columns.next_multiple_of(2), 0);
        let mut out = vec![i16::MAX; self.rows() + 1];
        apply(&layer, &input, &mut out, finish);
        assert_eq!(out.pop(), Some(i16::MAX), "wrote behind the last row");
        out
    }

    fn check(&self, x: &[i8]) {
        for finish in [Finish::Rectified, Finish::Wide] {
            let expected = self.expected(x, finish);
            assert_eq!(self.outputs(x, finish, |layer, x, out, finish| layer.apply(x, out, finish)), expected);
            assert_eq!(self.outputs(x, finish, portable::apply), expected);
        }
    }
}

fn layers() -> impl Strategy<Value = (Plain, Vec<i8>)> {
    (1..=20usize, prop_oneof![1..=80usize, Just(140), Just(255), Just(MAX_COLUMNS)]).prop_flat_map(|(rows, columns)| {
        let weights = vec(any::<i8>(), rows * columns);
        let biases = vec(-(1i32 << 24)..=1 << 24, rows);
        let multipliers = vec(0..=i32::MAX, rows);
        let plain = (weights, biases, multipliers).prop_map(move |(weights, biases, multipliers)| Plain {
            columns,
            weights,
            biases,
            multipliers,
        });
        (plain, vec(any::<i8>(), columns))
    })
}

proptest! {
    #[test]
    fn any_layer_is_the_plain_sum((plain, x) in layers()) {
        plain.check(&x);
    }

    #[test]
    fn small_sums_are_told_apart(x in vec(-2i8..=2, 64), seed in any::<u8>()) {
        // Factor one: the output is the sum itself, so an error of one in any accumulator shows.
        let mut plain = Plain::filled(9, 64, 0, 1 << 28);
        for (k, w) in plain.weights.iter_mut().enumerate() {
            *w = ((k as u8).wrapping_mul(37) ^ seed) as i8;
        }
        plain.check(&x);
    }
}

#[test]
fn the_longest_rows_of_the_most_extreme_values_are_exact() {
    for columns in [1, 2, 63, 64, 255, MAX_COLUMNS] {
        for weight in [-128, -127, 127] {
            for x in [-128, -127, 127] {
                for multiplier in [1 << 12, 1 << 21, i32::MAX] {
                    Plain::filled(5, columns, weight, multiplier).check(&vec![x; columns]);
                }
            }
        }
    }
}

#[test]
fn the_rows_of_a_pair_do_not_mix() {
    // One row at one end of the range, its partner at the other, in both orders.
    for (a, b) in [(-128, 127), (127, -128)] {
        let mut plain = Plain::filled(4, MAX_COLUMNS, a, 1 << 21);
        for row in [1, 3] {
            plain.weights[row * MAX_COLUMNS..][..MAX_COLUMNS].fill(b);
        }
        for x in [-128, -1, 0, 1, 127] {
            plain.check(&[x; MAX_COLUMNS]);
        }
    }
}

#[test]
fn rows_that_some_part_lacks_are_left_alone() {
    let weights: Vec<u8> = (0..8 * 4).collect();
    let (biases, multipliers) = ([[0; 4]; 8], [(1i32 << 30).to_le_bytes(); 8]);
    let whole = Dense { weights: &weights, biases: &biases, multipliers: &multipliers };
    let outputs = |layer: Dense<'_>, places: usize| {
        let mut out = [-1; 8];
        layer.apply(&[1, 1, 1, 1], &mut out[..places], Finish::Wide);
        out
    };
    let all = outputs(whole, 8);
    assert!(!all.contains(&-1));
    let first = |n: usize| -> [i16; 8] { core::array::from_fn(|k| if k < n { all[k] } else { -1 }) };
    assert_eq!(outputs(whole, 3), first(3));
    assert_eq!(outputs(Dense { weights: &weights[..20], ..whole }, 8), first(4));
    assert_eq!(outputs(Dense { biases: &biases[..5], ..whole }, 8), first(5));
    assert_eq!(outputs(Dense { multipliers: &multipliers[..1], ..whole }, 8), first(1));
    let mut out = [-1; 8];
    whole.apply(&[], &mut out, Finish::Wide);
    assert_eq!(out, [-1; 8]);
}
