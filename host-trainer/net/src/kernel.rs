//! The one kernel under every product, and what chooses it for the processor.
//!
//! All products of a network are sums of rows: `out[r] = Σ_i v[r, i] · w[i]`. Forward, r is
//! a sample, i an input, w the weights; backward, w is their transpose; for weight
//! gradients r is an input and i a sample, w the gradient at the outputs. In each of them
//! many v are zero (absent neighbours and PoIs, inputs that a ReLU cut off), so a bit mask
//! names those that are not and the kernel visits only these. A visit costs one
//! broadcast and up to eight fused multiply-adds into registers.
//!
//! Rows with few zeros go three at a time, zeros included: a weight fetched once serves
//! three. Adding a zero changes no sum, so this changes no result.
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
/// Share of values that count, as a fraction, above which zeros are multiplied too.
/// Measured.
const DENSE: (usize, usize) = (3, 4);
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
                        mask |= u64::from(!(*s <= 0.0)) << c;
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

/// Sets the bits of the numbers that are not zero: word `r·mask_step + c/64`, bit c mod 64
/// for the number at `r·step + c`, c below `width`.
///
/// # Panics
/// When a slice is too short for what the numbers say.
pub fn mark(values: &[f32], step: usize, width: usize, masks: &mut [u64], mask_step: usize) {
    struct Mark<'a>(&'a [f32], usize, usize, &'a mut [u64], usize);
    impl Vectorised for Mark<'_> {
        type Output = ();
        #[inline(always)]
        fn call(self) {
            let Self(values, step, width, masks, mask_step) = self;
            for (row, masks) in values.chunks(step).zip(masks.chunks_mut(mask_step)) {
                for (word, block) in masks.iter_mut().zip(row[..width].chunks(64)) {
                    *word = block.iter().enumerate().fold(0, |m, (c, v)| m | u64::from(*v != 0.0) << c);
                }
            }
        }
    }
    vectorised(Mark(values, step, width, masks, mask_step));
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{DENSE, Finish, LANES, Product, Start};
    use std::arch::x86_64::{
        __m256, _CMP_LE_OQ, _CMP_NLE_UQ, _mm256_andnot_ps, _mm256_broadcast_ss, _mm256_cmp_ps, _mm256_fmadd_ps,
        _mm256_loadu_ps, _mm256_movemask_ps, _mm256_setzero_ps, _mm256_storeu_ps,
    };

    /// # Safety
    /// `p.check` must have passed for these arguments and an output that `out` begins.
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    pub unsafe fn run(p: &Product<'_>, start: Start<'_>, finish: Finish<'_>, out: *mut f32, out_step: usize) {
        // SAFETY: as promised by the caller.
        unsafe {
            match p.columns / LANES {
                1 => rows::<1>(p, start, finish, out, out_step),
                2 => rows::<2>(p, start, finish, out, out_step),
                3 => rows::<3>(p, start, finish, out, out_step),
                4 => rows::<4>(p, start, finish, out, out_step),
                5 => rows::<5>(p, start, finish, out, out_step),
                6 => rows::<6>(p, start, finish, out, out_step),
                7 => rows::<7>(p, start, finish, out, out_step),
                _ => rows::<8>(p, start, finish, out, out_step),
            }
        }
    }

    /// # Safety
    /// As for [`run`], with `N` vectors of columns.
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn rows<const N: usize>(
        p: &Product<'_>,
        start: Start<'_>,
        mut finish: Finish<'_>,
        out: *mut f32,
        out_step: usize,
    ) {
        // Known steps spare multiplications in the innermost loop.
        let plain = p.weight_step == LANES * N && p.steps[1] == 1;
        let mut r = 0;
        while r < p.rows {
            // SAFETY: as promised by the caller.
            unsafe {
                if (N == 8 || N <= 4) && r + 3 <= p.rows && are_dense(p, r) {
                    if N == 8 {
                        three::<4>(p, r, 0, start, &mut finish, out, out_step);
                        three::<4>(p, r, 4, start, &mut finish, out, out_step);
                    } else {
                        three::<N>(p, r, 0, start, &mut finish, out, out_step);
                    }
                    r += 3;
                } else {
                    if plain {
                        row::<N, true>(p, r, start, &mut finish, out, out_step);
                    } else {
                        row::<N, false>(p, r, start, &mut finish, out, out_step);
                    }
                    r += 1;
                }
            }
        }
    }

    /// Row r, without its zeros.
    ///
    /// # Safety
    /// As for [`run`], with `N` vectors of columns; if `PLAIN`, terms and weights lie
    /// side by side.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn row<const N: usize, const PLAIN: bool>(
        p: &Product<'_>,
        r: usize,
        start: Start<'_>,
        finish: &mut Finish<'_>,
        out: *mut f32,
        out_step: usize,
    ) {
        let step = if PLAIN { 1 } else { p.steps[1] };
        let weight_step = if PLAIN { LANES * N } else { p.weight_step };
        // SAFETY: `check` saw that row r of every slice is within it up to the last block,
        // and `limit` drops bits beyond the last term, so that every i is within too.
        unsafe {
            let row = out.add(r * out_step);
            let mut sums = match start {
                Start::Zero => [_mm256_setzero_ps(); N],
                Start::Kept => load::<N>(row),
                Start::Bias(bias) => load::<N>(bias.as_ptr()),
            };
            for b in 0..p.terms.div_ceil(64) {
                let mut mask = *p.masks.get_unchecked(r * p.mask_step + b) & p.limit(b);
                let values = p.values.as_ptr().add(r * p.steps[0] + 64 * b * step);
                let weights = p.weights.as_ptr().add(64 * b * weight_step);
                // Two at a time, counted: a tenth faster than bit by bit.
                for _ in 0..mask.count_ones() / 2 {
                    let first = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let second = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    add(&mut sums, values.add(first * step), weights.add(first * weight_step));
                    add(&mut sums, values.add(second * step), weights.add(second * weight_step));
                }
                if mask != 0 {
                    let last = mask.trailing_zeros() as usize;
                    add(&mut sums, values.add(last * step), weights.add(last * weight_step));
                }
            }
            close(&mut sums, finish, r, 0);
            for (k, s) in sums.into_iter().enumerate() {
                _mm256_storeu_ps(row.add(LANES * k), s);
            }
        }
    }

    /// Whether so many values of rows r to r + 2 count that all may as well be multiplied.
    ///
    /// # Safety
    /// As for [`run`], with three rows from r.
    #[inline]
    #[target_feature(enable = "popcnt")]
    unsafe fn are_dense(p: &Product<'_>, r: usize) -> bool {
        let mut needed = (3 * p.terms * DENSE.0 / DENSE.1) as u32;
        for b in 0..p.terms.div_ceil(64) {
            for r in r..r + 3 {
                // SAFETY: as promised by the caller.
                let marked = unsafe { (p.masks.get_unchecked(r * p.mask_step + b) & p.limit(b)).count_ones() };
                // The way out keeps the compiler from vectorising a loop of a few words.
                needed = match needed.checked_sub(marked) {
                    None => return true,
                    Some(left) => left,
                };
            }
        }
        false
    }

    /// Rows r to r + 2 of `N` vectors of columns from vector `first`, zeros included.
    ///
    /// # Safety
    /// As for [`run`], with three rows from r and `first + N` vectors of columns.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn three<const N: usize>(
        p: &Product<'_>,
        r: usize,
        first: usize,
        start: Start<'_>,
        finish: &mut Finish<'_>,
        out: *mut f32,
        out_step: usize,
    ) {
        // SAFETY: as promised by the caller.
        unsafe {
            let out = out.add(r * out_step + LANES * first);
            let mut sums = [[_mm256_setzero_ps(); N]; 3];
            for (k, sums) in sums.iter_mut().enumerate() {
                *sums = match start {
                    Start::Zero => [_mm256_setzero_ps(); N],
                    Start::Kept => load::<N>(out.add(k * out_step)),
                    Start::Bias(bias) => load::<N>(bias.as_ptr().add(LANES * first)),
                };
            }
            let mut v = p.values.as_ptr().add(r * p.steps[0]);
            let mut w = p.weights.as_ptr().add(LANES * first);
            for _ in 0..p.terms {
                let values = [
                    _mm256_broadcast_ss(&*v),
                    _mm256_broadcast_ss(&*v.add(p.steps[0])),
                    _mm256_broadcast_ss(&*v.add(2 * p.steps[0])),
                ];
                for c in 0..N {
                    let w = _mm256_loadu_ps(w.add(LANES * c));
                    for k in 0..3 {
                        sums[k][c] = _mm256_fmadd_ps(values[k], w, sums[k][c]);
                    }
                }
                v = v.wrapping_add(p.steps[1]);
                w = w.wrapping_add(p.weight_step);
            }
            for (k, mut sums) in sums.into_iter().enumerate() {
                close(&mut sums, finish, r + k, first);
                for (c, s) in sums.into_iter().enumerate() {
                    _mm256_storeu_ps(out.add(k * out_step + LANES * c), s);
                }
            }
        }
    }

    /// # Safety
    /// `N` vectors can be read at `from`.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn load<const N: usize>(from: *const f32) -> [__m256; N] {
        // SAFETY: as promised by the caller.
        std::array::from_fn(|k| unsafe { _mm256_loadu_ps(from.add(LANES * k)) })
    }

    /// # Safety
    /// A number can be read at `v` and `N` vectors at `w`.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn add<const N: usize>(sums: &mut [__m256; N], v: *const f32, w: *const f32) {
        // SAFETY: as promised by the caller.
        unsafe {
            let v = _mm256_broadcast_ss(&*v);
            for (k, s) in sums.iter_mut().enumerate() {
                *s = _mm256_fmadd_ps(v, _mm256_loadu_ps(w.add(LANES * k)), *s);
            }
        }
    }

    /// # Safety
    /// `check` must have passed for `finish` with a row `r`; `sums` are its vectors from
    /// `first`.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn close<const N: usize>(sums: &mut [__m256; N], finish: &mut Finish<'_>, r: usize, first: usize) {
        let zero = _mm256_setzero_ps();
        match finish {
            Finish::Plain => {}
            Finish::Relu { masks, step } => {
                let mut mask = 0;
                for (k, s) in sums.iter_mut().enumerate() {
                    let keep = _mm256_cmp_ps::<_CMP_NLE_UQ>(*s, zero);
                    mask |= u64::from(_mm256_movemask_ps(keep) as u32) << (LANES * (first + k));
                    *s = _mm256_andnot_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(*s, zero), *s);
                }
                // SAFETY: as promised by the caller.
                let word = unsafe { masks.get_unchecked_mut(r * *step) };
                *word = if first == 0 { mask } else { *word | mask };
            }
            Finish::Gate { active, step } => {
                for (k, s) in sums.iter_mut().enumerate() {
                    // SAFETY: as promised by the caller.
                    let a = unsafe { _mm256_loadu_ps(active.as_ptr().add(r * *step + LANES * (first + k))) };
                    *s = _mm256_andnot_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, zero), *s);
                }
            }
        }
    }
}
