//! The kernel for AVX2 with FMA.

use super::lanes::LANES;
use super::product::{Epilogue, Init, Product};
use std::arch::x86_64::{
    __m256, _CMP_LE_OQ, _CMP_NLE_UQ, _mm_cmpeq_epi8, _mm_loadl_epi64, _mm_movemask_epi8, _mm_setzero_si128,
    _mm256_and_ps, _mm256_andnot_ps, _mm256_broadcast_ss, _mm256_cmp_ps, _mm256_cvtepi8_epi32, _mm256_cvtepi32_ps,
    _mm256_fmadd_ps, _mm256_loadu_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps, _mm256_setzero_ps,
    _mm256_storeu_ps,
};

/// Terms of a block: a word of a mask, and so few weights that they stay in the first-level
/// cache.
const TERMS: usize = 64;

/// # Safety
/// `p.check` must have passed for these arguments and an output that `out` begins.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
pub unsafe fn run(p: &Product<'_>, init: Init<'_>, mut epilogue: Epilogue<'_>, out: *mut f32, out_step: usize) {
    let (vectors, mut first) = (p.columns / LANES, 0);
    while first < vectors {
        let n = match vectors - first {
            few @ (1..=3 | 8) => few,
            _ => 4,
        };
        let blocks = p.terms.div_ceil(TERMS).max(1);
        for b in 0..blocks {
            let at = TERMS * b;
            let terms = (p.terms - at).min(TERMS);
            let block = Block {
                init: if b == 0 { init } else { Init::Accumulate },
                terms,
                limit: if terms == TERMS { u64::MAX } else { (1 << terms) - 1 },
                values: p.values.as_ptr().wrapping_add(at * p.steps[1]),
                steps: p.steps,
                masks: &p.masks[b.min(p.masks.len())..],
                mask_step: p.mask_step,
                weights: p.weights.as_ptr().wrapping_add(at * p.weight_step + LANES * first),
                weight_step: p.weight_step,
                first,
                out: out.wrapping_add(LANES * first),
                out_step,
            };
            let epilogue = if b + 1 == blocks { &mut epilogue } else { &mut Epilogue::Identity };
            // SAFETY: as promised by the caller; the block's terms and columns are the product's.
            unsafe {
                match n {
                    1 => block.run::<1, 6>(p.rows, epilogue),
                    2 => block.run::<2, 4>(p.rows, epilogue),
                    3 => block.run::<3, 3>(p.rows, epilogue),
                    4 => block.run::<4, 3>(p.rows, epilogue),
                    _ => block.run::<8, 3>(p.rows, epilogue),
                }
            }
        }
        first += n;
    }
}

/// Some columns of a product and up to 64 terms of its sums.
struct Block<'p> {
    init: Init<'p>,
    terms: usize,
    /// A bit for each term.
    limit: u64,
    /// Of the first term in row 0.
    values: *const f32,
    steps: [usize; 2],
    /// Of the first row.
    masks: &'p [u64],
    mask_step: usize,
    /// Of the first term.
    weights: *const f32,
    weight_step: usize,
    /// The first vector of columns.
    first: usize,
    /// Where that is in row 0 of the output.
    out: *mut f32,
    out_step: usize,
}

impl Block<'_> {
    /// All rows; those with few zeros `M` at a time.
    ///
    /// # Safety
    /// As for [`run`], with `N` vectors of columns in the block.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn run<const N: usize, const M: usize>(&self, rows: usize, epilogue: &mut Epilogue<'_>) {
        // SAFETY: as promised by the caller.
        unsafe {
            // Known steps spare multiplications in the innermost loop.
            match (self.weight_step == LANES * N, self.steps[1] == 1) {
                (true, true) => self.rows::<N, M, true, true>(rows, epilogue),
                (true, false) => self.rows::<N, M, true, false>(rows, epilogue),
                (false, _) => self.rows::<N, M, false, false>(rows, epilogue),
            }
        }
    }

    /// # Safety
    /// As for [`Self::sparse_row`] and all rows.
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn rows<const N: usize, const M: usize, const PACKED: bool, const SIDE_BY_SIDE: bool>(
        &self,
        rows: usize,
        epilogue: &mut Epilogue<'_>,
    ) {
        // Weight gradients of inputs that were zero throughout.
        let additive = matches!((&self.init, &epilogue), (Init::Accumulate, Epilogue::Identity));
        let most = self.sparse_limit::<N>();
        let (mut waiting, mut dense) = (0, [0; M]);
        for k in 0..rows + M {
            // Behind the last row, those that wait.
            let r = match k.checked_sub(rows) {
                None => k,
                Some(k) if k < waiting => dense[k],
                Some(_) => break,
            };
            let mask = self.mask(r);
            if mask.count_ones() as usize > most && k < rows {
                dense[waiting] = r;
                waiting += 1;
                if waiting == M {
                    // SAFETY: as promised by the caller.
                    unsafe { self.dense_rows::<N, M>(dense, epilogue) };
                    waiting = 0;
                }
            } else if mask != 0 || !additive {
                // SAFETY: as promised by the caller.
                unsafe { self.sparse_row::<N, PACKED, SIDE_BY_SIDE>(r, mask, epilogue) };
            }
        }
    }

    /// Most values that may count in a row that goes alone, without its zeros. Measured: alone, it waits for the
    /// last addition to each sum, and with few sums that is most of its time.
    #[inline(always)]
    const fn sparse_limit<const N: usize>(&self) -> usize {
        match N {
            8 => self.terms * 2 / 3,
            4 => self.terms * 2 / 5,
            _ => self.terms / 4,
        }
    }

    /// Mask of row r.
    #[inline(always)]
    fn mask(&self, r: usize) -> u64 {
        // Without terms there are no masks.
        self.masks.get(r * self.mask_step).map_or(0, |mask| mask & self.limit)
    }

    /// Row r, without its zeros.
    ///
    /// # Safety
    /// As for [`run`], with `N` vectors of columns in the block and a row r that has this
    /// mask; if `PACKED`, rows of weights follow each other, and if `SIDE_BY_SIDE`, the values
    /// of a row do.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn sparse_row<const N: usize, const PACKED: bool, const SIDE_BY_SIDE: bool>(
        &self,
        r: usize,
        mut mask: u64,
        epilogue: &mut Epilogue<'_>,
    ) {
        let step = if SIDE_BY_SIDE { 1 } else { self.steps[1] };
        let weight_step = if PACKED { LANES * N } else { self.weight_step };
        let (values, weights) = (self.values.wrapping_add(r * self.steps[0]), self.weights);
        // SAFETY: `check` saw that row r of every slice is within it, and `limit` drops bits
        // beyond the last term, so that every term is within too.
        unsafe {
            let mut sums = self.load_sums::<N>(r, 0);
            // Four at a time, counted: faster than bit by bit.
            for _ in 0..mask.count_ones() / 4 {
                for _ in 0..4 {
                    let i = pop_lowest_bit(&mut mask);
                    add(&mut sums, values.add(i * step), weights.add(i * weight_step));
                }
            }
            while mask != 0 {
                let i = pop_lowest_bit(&mut mask);
                add(&mut sums, values.add(i * step), weights.add(i * weight_step));
            }
            self.store_sums(sums, r, 0, epilogue);
        }
    }

    /// Rows that have few zeros, zeros included: a weight fetched once serves them all.
    ///
    /// # Safety
    /// As for [`run`], with `N` vectors of columns in the block and these rows.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn dense_rows<const N: usize, const M: usize>(&self, rows: [usize; M], epilogue: &mut Epilogue<'_>) {
        // SAFETY: as promised by the caller.
        unsafe {
            // Twelve sums and what they need fill the registers.
            if N == 8 {
                self.tile::<4, M>(rows, 0, epilogue);
                self.tile::<4, M>(rows, 4, epilogue);
            } else {
                self.tile::<N, M>(rows, 0, epilogue);
            }
        }
    }

    /// `N` vectors of columns of some rows, from the block's vector `more`.
    ///
    /// # Safety
    /// As for [`run`], with `more + N` vectors of columns in the block and these rows.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    unsafe fn tile<const N: usize, const M: usize>(&self, rows: [usize; M], more: usize, epilogue: &mut Epilogue<'_>) {
        // SAFETY: as promised by the caller.
        unsafe {
            let mut sums: [[__m256; N]; M] = [[_mm256_setzero_ps(); N]; M];
            for (sums, r) in sums.iter_mut().zip(rows) {
                *sums = self.load_sums(r, more);
            }
            let mut values = rows.map(|r| self.values.wrapping_add(r * self.steps[0]));
            let mut weights = self.weights.wrapping_add(LANES * more);
            for _ in 0..self.terms {
                let mut v = [_mm256_setzero_ps(); M];
                for (v, from) in v.iter_mut().zip(&mut values) {
                    *v = _mm256_broadcast_ss(&**from);
                    // Beyond the last term nothing is read.
                    *from = from.wrapping_add(self.steps[1]);
                }
                for k in 0..N {
                    let w = _mm256_loadu_ps(weights.add(LANES * k));
                    for (sums, v) in sums.iter_mut().zip(v) {
                        sums[k] = _mm256_fmadd_ps(v, w, sums[k]);
                    }
                }
                weights = weights.wrapping_add(self.weight_step);
            }
            for (sums, r) in sums.into_iter().zip(rows) {
                self.store_sums(sums, r, more, epilogue);
            }
        }
    }

    /// What the sums of row r start from, those from the block's vector `more`.
    ///
    /// # Safety
    /// As for [`run`], with `more + N` vectors of columns in the block and a row r.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn load_sums<const N: usize>(&self, r: usize, more: usize) -> [__m256; N] {
        // SAFETY: as promised by the caller.
        unsafe {
            match self.init {
                Init::Zero => [_mm256_setzero_ps(); N],
                Init::Accumulate => load(self.out.add(r * self.out_step + LANES * more)),
                Init::Bias(bias) => load(bias.as_ptr().add(LANES * (self.first + more))),
            }
        }
    }

    /// Applies the epilogue to the sums of row r and stores them.
    ///
    /// # Safety
    /// As for [`Self::load_sums`].
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn store_sums<const N: usize>(
        &self,
        mut sums: [__m256; N],
        r: usize,
        more: usize,
        epilogue: &mut Epilogue<'_>,
    ) {
        let (zero, first) = (_mm256_setzero_ps(), self.first + more);
        match epilogue {
            Epilogue::Identity => {}
            Epilogue::Relu { masks, step } => {
                let mut mask = 0;
                for (k, s) in sums.iter_mut().enumerate() {
                    let keep = _mm256_cmp_ps::<_CMP_NLE_UQ>(*s, zero);
                    mask |= u64::from(_mm256_movemask_ps(keep) as u32) << (LANES * (first + k));
                    *s = _mm256_and_ps(keep, *s);
                }
                // SAFETY: as promised by the caller.
                let word = unsafe { masks.get_unchecked_mut(r * *step) };
                *word = if first == 0 { mask } else { *word | mask };
            }
            Epilogue::ReluGradient { outputs, step } => {
                for (k, s) in sums.iter_mut().enumerate() {
                    // SAFETY: as promised by the caller.
                    let a = unsafe { _mm256_loadu_ps(outputs.as_ptr().add(r * *step + LANES * (first + k))) };
                    *s = _mm256_andnot_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, zero), *s);
                }
            }
        }
        for (k, s) in sums.into_iter().enumerate() {
            // SAFETY: as promised by the caller.
            unsafe { _mm256_storeu_ps(self.out.add(r * self.out_step + LANES * (more + k)), s) };
        }
    }
}

/// Number of the lowest bit that is set; clears it.
#[inline(always)]
const fn pop_lowest_bit(mask: &mut u64) -> usize {
    let i = mask.trailing_zeros() as usize;
    *mask &= mask.wrapping_sub(1);
    i
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

/// int8 numbers to floats times `scale`, eight at a time, and a bit for each number that is not zero.
///
/// # Safety
/// `bytes` and `out` must be as long as `eights` times eight, `masks` have a word for every
/// eight of these.
#[target_feature(enable = "avx2")]
pub unsafe fn dequantise(bytes: *const i8, eights: usize, scale: f32, out: *mut f32, masks: *mut u64) {
    // SAFETY: as promised by the caller.
    unsafe {
        let scale = _mm256_set1_ps(scale);
        for w in 0..eights.div_ceil(8) {
            let mut word = 0;
            for k in 8 * w..eights.min(8 * w + 8) {
                let eight = _mm_loadl_epi64(bytes.add(8 * k).cast());
                let floats = _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(eight));
                _mm256_storeu_ps(out.add(8 * k), _mm256_mul_ps(floats, scale));
                let zeros = _mm_movemask_epi8(_mm_cmpeq_epi8(eight, _mm_setzero_si128()));
                word |= u64::from(!zeros as u8) << (8 * (k % 8));
            }
            *masks.add(w) = word;
        }
    }
}
