//! The one kernel under every product, and what chooses it for the processor.
//!
//! All products of a network are sums of rows: `out[r] = Σ_i v[r, i] · w[i]`. Forward, r is
//! a sample, i an input, w the weights; backward, w is their transpose; for weight
//! gradients r is an input and i a sample, w the gradient at the outputs. In each of them
//! many v are zero (absent neighbours and PoIs, inputs that a ReLU cut off), so a bit mask
//! names those that are not and the kernel visits only these. A visit costs one
//! broadcast and up to eight fused multiply-adds into registers.
//!
//! Rows with few zeros go together, zeros included: a weight fetched once serves all of
//! them. Adding a zero changes no sum, so this changes no result.
//!
//! Terms are added in ascending i by fused multiply-adds, whatever the instruction set:
//! results are the same to the bit on every processor. Without AVX2 and FMA on x86 they are
//! slow, not different.
//!
//! Unsafe code is in this module alone.
#![allow(unsafe_code)]

use std::ops::{Deref, DerefMut};

/// Numbers in a vector of the kernel; columns come in multiples of it.
pub const LANES: usize = 8;
/// Most columns of a product: eight vectors.
pub const PANEL: usize = 64;
/// Numbers to a cache line.
const LINE: usize = 16;

/// `n` up to whole vectors.
#[must_use]
pub const fn padded(n: usize) -> usize {
    n.div_ceil(LANES) * LANES
}

/// A cache line of numbers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

/// Numbers that begin at a cache line, so that no vector of an even row lies in two:
/// that costs the kernel a quarter of its speed.
#[derive(Clone, Debug, Default)]
pub struct Aligned {
    lines: Vec<Line>,
    len: usize,
}

impl Aligned {
    /// So many zeros.
    #[must_use]
    pub fn zeros(len: usize) -> Self {
        Self { lines: vec![Line([0.0; LINE]); len.div_ceil(LINE)], len }
    }

    /// Grows to `len` with zeros; never shrinks.
    pub fn grow(&mut self, len: usize) {
        if len > self.len {
            self.lines.resize(len.div_ceil(LINE), Line([0.0; LINE]));
            self.len = len;
        }
    }
}

impl Deref for Aligned {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        // SAFETY: `Line` is 16 floats without padding, and `len` is at most 16 a line.
        unsafe { std::slice::from_raw_parts(self.lines.as_ptr().cast(), self.len) }
    }
}

impl DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f32] {
        // SAFETY: as in `deref`; the borrow is exclusive.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), self.len) }
    }
}

/// Work on plain slices that the compiler vectorises: compiled twice, once for AVX2 with
/// FMA.
pub trait Vectorised {
    /// What it gives.
    type Output;

    /// Does it. Must be `#[inline(always)]`, and so must what it calls, or it is compiled
    /// for the oldest processor only.
    fn call(self) -> Self::Output;
}

/// Does the work with what this processor has.
pub fn vectorised<V: Vectorised>(work: V) -> V::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn wide<V: Vectorised>(work: V) -> V::Output {
            work.call()
        }
        if is_wide() {
            // SAFETY: the processor has what `wide` is compiled for.
            return unsafe { wide(work) };
        }
    }
    work.call()
}

/// Whether this processor has AVX2, FMA and what comes with them.
#[must_use]
pub fn is_wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// What a row of a product starts from.
#[derive(Clone, Copy, Debug)]
pub enum Start<'a> {
    /// Zeros.
    Zero,
    /// What stands in the output.
    Kept,
    /// The same numbers for every row, as many as columns.
    Bias(&'a [f32]),
}

/// What happens to a row's sums before they are stored.
#[derive(Debug)]
pub enum Finish<'a> {
    /// Nothing.
    Plain,
    /// Negative sums become zero. Bits of those above zero go to word `r·step` for row r:
    /// bit c for column c.
    Relu {
        /// The words.
        masks: &'a mut [u64],
        /// Words from row to row.
        step: usize,
    },
    /// Sums become zero where the number at `r·step + c` is not above zero: the gradient
    /// of a ReLU by its own output.
    Gate {
        /// Outputs of the ReLU.
        active: &'a [f32],
        /// Numbers from row to row.
        step: usize,
    },
}

/// `out[r] = start + Σ_i values[r, i] · weights[i]` over the i in row r's mask.
#[derive(Debug)]
pub struct Product<'a> {
    /// Rows.
    pub rows: usize,
    /// Terms of a sum.
    pub terms: usize,
    /// Columns, a multiple of [`LANES`], at most [`PANEL`].
    pub columns: usize,
    /// v: number of row r and term i at `r·steps[0] + i·steps[1]`.
    pub values: &'a [f32],
    /// Steps through `values`, from row to row and from term to term.
    pub steps: [usize; 2],
    /// Bit i mod 64 of word `r·mask_step + i/64` tells whether `v[r, i]` counts.
    pub masks: &'a [u64],
    /// Words from row to row.
    pub mask_step: usize,
    /// w: row i at `i·weight_step`.
    pub weights: &'a [f32],
    /// Numbers from row to row of `weights`.
    pub weight_step: usize,
}

impl Product<'_> {
    /// Computes it; row r goes to `out[r·out_step..]`.
    ///
    /// # Panics
    /// When a slice is too short for what the numbers say.
    pub fn run(&self, start: Start<'_>, finish: Finish<'_>, out: &mut [f32], out_step: usize) {
        if self.rows == 0 {
            return;
        }
        self.check(&start, &finish, out.len(), out_step);
        #[cfg(target_arch = "x86_64")]
        if is_wide() {
            // SAFETY: the processor has what it takes, and `check` saw that every place is
            // within its slice.
            unsafe { avx2::run(self, start, finish, out.as_mut_ptr(), out_step) };
            return;
        }
        self.plain(start, finish, out, out_step);
    }

    fn check(&self, start: &Start<'_>, finish: &Finish<'_>, out: usize, out_step: usize) {
        let (last, columns) = (self.rows - 1, self.columns);
        let words = self.terms.div_ceil(64);
        assert!(columns > 0 && columns <= PANEL && columns.is_multiple_of(LANES), "columns in whole vectors");
        assert!(last * out_step + columns <= out, "output too short");
        assert!(last * self.mask_step + words <= self.masks.len(), "masks too short");
        if let Some(term) = self.terms.checked_sub(1) {
            assert!(last * self.steps[0] + term * self.steps[1] < self.values.len(), "values too short");
            assert!(term * self.weight_step + columns <= self.weights.len(), "weights too short");
        }
        if let Start::Bias(bias) = start {
            assert!(columns <= bias.len(), "bias too short");
        }
        match finish {
            Finish::Plain => {}
            Finish::Relu { masks, step } => assert!(last * step < masks.len(), "room for masks too short"),
            Finish::Gate { active, step } => assert!(last * step + columns <= active.len(), "gate too short"),
        }
    }

    /// Mask of the terms of block `b` (64 terms) that exist.
    #[inline(always)]
    const fn limit(&self, b: usize) -> u64 {
        let left = self.terms - 64 * b;
        if left >= 64 { u64::MAX } else { (1 << left) - 1 }
    }

    /// The same in plain code.
    fn plain(&self, start: Start<'_>, mut finish: Finish<'_>, out: &mut [f32], out_step: usize) {
        for r in 0..self.rows {
            let row = &mut out[r * out_step..][..self.columns];
            match start {
                Start::Zero => row.fill(0.0),
                Start::Kept => {}
                Start::Bias(bias) => row.copy_from_slice(&bias[..self.columns]),
            }
            for b in 0..self.terms.div_ceil(64) {
                let mut mask = self.masks[r * self.mask_step + b] & self.limit(b);
                while mask != 0 {
                    let i = 64 * b + mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let v = self.values[r * self.steps[0] + i * self.steps[1]];
                    let weights = &self.weights[i * self.weight_step..][..self.columns];
                    row.iter_mut().zip(weights).for_each(|(s, w)| *s = v.mul_add(*w, *s));
                }
            }
            match &mut finish {
                Finish::Plain => {}
                Finish::Relu { masks, step } => {
                    let mut mask = 0;
                    for (c, s) in row.iter_mut().enumerate() {
                        // What is not a number stays so that it is noticed.
                        mask |= u64::from(*s > 0.0 || s.is_nan()) << c;
                        *s = if *s <= 0.0 { 0.0 } else { *s };
                    }
                    masks[r * *step] = mask;
                }
                Finish::Gate { active, step } => {
                    let active = &active[r * *step..][..self.columns];
                    row.iter_mut().zip(active).for_each(|(s, a)| *s = if *a <= 0.0 { 0.0 } else { *s });
                }
            }
        }
    }
}

/// Multiply-adds that depend on nothing in memory, as many at a time as keep a core's
/// units busy: the peak that products are measured against. Returns how many it did.
#[must_use]
pub fn multiply_adds(rounds: u64) -> u64 {
    struct Chains(u64);
    impl Vectorised for Chains {
        type Output = u64;
        #[inline(always)]
        fn call(self) -> u64 {
            const CHAINS: usize = 12;
            let (factor, term) = (std::hint::black_box(0.5f32), std::hint::black_box(1.0f32));
            let mut sums = [[0.0f32; LANES]; CHAINS];
            for _ in 0..self.0 {
                for chain in &mut sums {
                    for s in chain {
                        *s = s.mul_add(factor, term);
                    }
                }
            }
            std::hint::black_box(sums);
            self.0 * (CHAINS * LANES) as u64
        }
    }
    vectorised(Chains(rounds))
}

/// Turns a row of bytes, whole eights of them, into floats times `scale`; bit k mod 64 of
/// word k/64 tells whether byte k is not zero.
///
/// # Panics
/// When `out` or `masks` is too short, or the bytes are not whole eights.
pub fn unpack(bytes: &[i8], scale: f32, out: &mut [f32], masks: &mut [u64]) {
    let (eights, rest) = bytes.as_chunks::<8>();
    assert!(rest.is_empty() && bytes.len() <= out.len() && bytes.len() <= 64 * masks.len(), "whole eights and room");
    #[cfg(target_arch = "x86_64")]
    if is_wide() {
        // SAFETY: the processor has what it takes, and the lengths are checked above.
        unsafe { avx2::unpack(bytes.as_ptr(), eights.len(), scale, out.as_mut_ptr(), masks.as_mut_ptr()) };
        return;
    }
    masks[..bytes.len().div_ceil(64)].fill(0);
    for (k, (x, &byte)) in out.iter_mut().zip(eights.as_flattened()).enumerate() {
        *x = f32::from(byte) * scale;
        masks[k / 64] |= u64::from(byte != 0) << (k % 64);
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A product of random shape with its start and finish.
    #[derive(Clone, Debug)]
    struct Case {
        rows: usize,
        terms: usize,
        columns: usize,
        values: Vec<f32>,
        masks: Vec<u64>,
        weights: Vec<f32>,
        out: Vec<f32>,
        start: u8,
        finish: u8,
        /// Values term by term rather than row by row.
        across: bool,
        /// Distance between rows of weights beyond their columns.
        gap: usize,
    }

    fn case() -> impl Strategy<Value = Case> {
        let shape = (1usize..=8, 0usize..=140, 1usize..=8, 0u8..3, 0u8..3, any::<bool>(), 0usize..3);
        shape.prop_flat_map(|(rows, terms, vectors, start, finish, across, gap)| {
            let (columns, words) = (vectors * LANES, terms.div_ceil(64).max(1));
            // Some rows are nearly full, others nearly empty.
            let value = (any::<bool>(), -1.0f32..1.0).prop_map(|(zero, v)| if zero { 0.0 } else { v });
            let full = prop::collection::vec(-1.0f32..1.0, rows * terms);
            let numbers = |n| prop::collection::vec(-1.0f32..1.0, n);
            (
                prop_oneof![prop::collection::vec(value, rows * terms), full],
                numbers(terms * (columns + gap) + columns),
                numbers(rows * columns),
                prop::collection::vec(any::<u64>(), rows * words),
            )
                .prop_map(move |(values, weights, out, noise)| {
                    // Terms that count, and bits of terms that there are not.
                    let mut masks = noise;
                    for r in 0..rows {
                        for i in 0..terms {
                            let at = if across { i * rows + r } else { r * terms + i };
                            let (word, bit) = (&mut masks[r * words + i / 64], 1 << (i % 64));
                            *word = if values[at] == 0.0 { *word & !bit } else { *word | bit };
                        }
                    }
                    Case { rows, terms, columns, values, masks, weights, out, start, finish, across, gap }
                })
        })
    }

    impl Case {
        /// Output and masks, by `run` or by `plain`.
        fn compute(&self, run: bool) -> (Vec<f32>, Vec<u64>) {
            let product = Product {
                rows: self.rows,
                terms: self.terms,
                columns: self.columns,
                values: &self.values,
                steps: if self.across { [1, self.rows] } else { [self.terms, 1] },
                masks: &self.masks,
                mask_step: self.terms.div_ceil(64).max(1),
                weights: &self.weights,
                weight_step: self.columns + self.gap,
            };
            let (mut out, mut masks) = (self.out.clone(), vec![0; self.rows]);
            let start = match self.start {
                0 => Start::Zero,
                1 => Start::Kept,
                _ => Start::Bias(&self.weights),
            };
            let finish = match self.finish {
                0 => Finish::Plain,
                1 => Finish::Relu { masks: &mut masks, step: 1 },
                _ => Finish::Gate { active: &self.out, step: self.columns },
            };
            if run {
                product.run(start, finish, &mut out, self.columns);
            } else {
                product.plain(start, finish, &mut out, self.columns);
            }
            (out, masks)
        }

        /// A sum in double precision.
        fn exact(&self, r: usize, c: usize) -> f64 {
            let start = match self.start {
                0 => 0.0,
                1 => self.out[r * self.columns + c],
                _ => self.weights[c],
            };
            let term = |i: usize| {
                let v = self.values[if self.across { i * self.rows + r } else { r * self.terms + i }];
                f64::from(v) * f64::from(self.weights[i * (self.columns + self.gap) + c])
            };
            let sum = f64::from(start) + (0..self.terms).map(term).sum::<f64>();
            match self.finish {
                1 => sum.max(0.0),
                2 if self.out[r * self.columns + c] <= 0.0 => 0.0,
                _ => sum,
            }
        }
    }

    proptest! {
        #[test]
        fn sums_are_right_and_the_same_on_any_processor(case in case()) {
            let (out, masks) = case.compute(true);
            let plain = case.compute(false);
            for (k, (a, b)) in out.iter().zip(&plain.0).enumerate() {
                // Zeros may differ in sign.
                prop_assert!(a == b, "{k}: {a} and {b}");
            }
            prop_assert_eq!(&masks, &plain.1);
            for r in 0..case.rows {
                for c in 0..case.columns {
                    let (got, exact) = (f64::from(out[r * case.columns + c]), case.exact(r, c));
                    prop_assert!((got - exact).abs() < 1e-5, "row {r}, column {c}: {got}, not {exact}");
                    if case.finish == 1 {
                        prop_assert_eq!(masks[r] >> c & 1 == 1, got > 0.0);
                    }
                }
            }
        }

        #[test]
        fn bytes_are_unpacked(bytes in prop::collection::vec(prop_oneof![Just(0i8), any::<i8>()], 0..160)) {
            let bytes = &bytes[..bytes.len() / 8 * 8];
            let (mut floats, mut masks) = (vec![f32::NAN; bytes.len() + 3], vec![u64::MAX; bytes.len().div_ceil(64)]);
            unpack(bytes, 0.5, &mut floats, &mut masks);
            for (k, &byte) in bytes.iter().enumerate() {
                prop_assert_eq!(floats[k], f32::from(byte) / 2.0);
                prop_assert_eq!(masks[k / 64] >> (k % 64) & 1 == 1, byte != 0);
            }
        }
    }

    #[test]
    #[should_panic(expected = "values too short")]
    fn a_product_beyond_its_slices_is_refused() {
        let product = Product {
            rows: 2,
            terms: 3,
            columns: 8,
            values: &[1.0; 5],
            steps: [3, 1],
            masks: &[7, 7],
            mask_step: 1,
            weights: &[1.0; 24],
            weight_step: 8,
        };
        product.run(Start::Zero, Finish::Plain, &mut [0.0; 16], 8);
    }

    #[test]
    fn lines_are_aligned() {
        let mut a = Aligned::zeros(17);
        a.grow(40);
        a.grow(3);
        assert_eq!((a.len(), a.as_ptr() as usize % 64), (40, 0));
    }
}
