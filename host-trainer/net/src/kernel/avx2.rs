//! The kernel for AVX2 with FMA.

use super::{DENSE, Finish, LANES, Product, Start};
use std::arch::x86_64::{
    __m256, _CMP_LE_OQ, _CMP_NLE_UQ, _mm_cmpeq_epi8, _mm_loadl_epi64, _mm_movemask_epi8, _mm_setzero_si128,
    _mm256_andnot_ps, _mm256_broadcast_ss, _mm256_cmp_ps, _mm256_cvtepi8_epi32, _mm256_cvtepi32_ps, _mm256_fmadd_ps,
    _mm256_loadu_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps, _mm256_setzero_ps, _mm256_storeu_ps,
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
    // Weight gradients of inputs that were zero throughout.
    let additive = p.terms <= 64 && matches!((&start, &finish), (Start::Kept, Finish::Plain));
    let (mut waiting, mut dense) = (0, [0; 3]);
    for r in 0..p.rows {
        // SAFETY: as promised by the caller.
        unsafe {
            if (N == 8 || N <= 4) && is_dense(p, r) {
                dense[waiting] = r;
                waiting += 1;
                if waiting == 3 {
                    three::<N>(p, dense, start, &mut finish, out, out_step);
                    waiting = 0;
                }
            } else if !additive || mask(p, r, 0) != 0 {
                one::<N>(p, r, start, &mut finish, out, out_step);
            }
        }
    }
    for r in &dense[..waiting] {
        // SAFETY: as promised by the caller.
        unsafe { one::<N>(p, *r, start, &mut finish, out, out_step) };
    }
}

/// Row r, without its zeros.
///
/// # Safety
/// As for [`run`], with `N` vectors of columns and a row r.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
unsafe fn one<const N: usize>(
    p: &Product<'_>,
    r: usize,
    start: Start<'_>,
    finish: &mut Finish<'_>,
    out: *mut f32,
    out_step: usize,
) {
    // SAFETY: as promised by the caller.
    unsafe {
        // Known steps spare multiplications in the innermost loop.
        match (p.weight_step == LANES * N, p.steps[1] == 1) {
            (true, true) => row::<N, true, true>(p, r, start, finish, out, out_step),
            (true, false) => row::<N, true, false>(p, r, start, finish, out, out_step),
            (false, _) => row::<N, false, false>(p, r, start, finish, out, out_step),
        }
    }
}

/// Rows that have few zeros, zeros included: a weight fetched once serves three.
///
/// # Safety
/// As for [`run`], with `N` vectors of columns and these rows.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
unsafe fn three<const N: usize>(
    p: &Product<'_>,
    rows: [usize; 3],
    start: Start<'_>,
    finish: &mut Finish<'_>,
    out: *mut f32,
    out_step: usize,
) {
    // SAFETY: as promised by the caller.
    unsafe {
        // Twelve sums and what they need fill the registers.
        if N == 8 {
            part::<4>(p, rows, 0, start, finish, out, out_step);
            part::<4>(p, rows, 4, start, finish, out, out_step);
        } else {
            part::<N>(p, rows, 0, start, finish, out, out_step);
        }
    }
}

/// Row r, without its zeros.
///
/// # Safety
/// As for [`run`], with `N` vectors of columns; if `PACKED`, rows of weights follow each
/// other, and if `SIDE_BY_SIDE`, the values of a row do.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
unsafe fn row<const N: usize, const PACKED: bool, const SIDE_BY_SIDE: bool>(
    p: &Product<'_>,
    r: usize,
    start: Start<'_>,
    finish: &mut Finish<'_>,
    out: *mut f32,
    out_step: usize,
) {
    let step = if SIDE_BY_SIDE { 1 } else { p.steps[1] };
    let weight_step = if PACKED { LANES * N } else { p.weight_step };
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
            let mut mask = mask(p, r, b);
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

/// Whether so many values of row r count that all may as well be multiplied.
///
/// # Safety
/// As for [`run`], with a row r.
#[inline]
#[target_feature(enable = "popcnt")]
unsafe fn is_dense(p: &Product<'_>, r: usize) -> bool {
    let mut needed = (p.terms * DENSE.0 / DENSE.1) as u32;
    for b in 0..p.terms.div_ceil(64) {
        // The way out keeps the compiler from vectorising a loop of a few words.
        // SAFETY: as promised by the caller.
        needed = match needed.checked_sub(unsafe { mask(p, r, b) }.count_ones()) {
            None => return true,
            Some(left) => left,
        };
    }
    false
}

/// Marks of row r in block `b`.
///
/// # Safety
/// As for [`run`], with a row r and a block `b`.
#[inline(always)]
unsafe fn mask(p: &Product<'_>, r: usize, b: usize) -> u64 {
    // SAFETY: as promised by the caller.
    unsafe { *p.masks.get_unchecked(r * p.mask_step + b) & p.limit(b) }
}

/// `N` vectors of columns of three rows, from vector `first`.
///
/// # Safety
/// As for [`run`], with `first + N` vectors of columns and these rows.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
unsafe fn part<const N: usize>(
    p: &Product<'_>,
    rows: [usize; 3],
    first: usize,
    start: Start<'_>,
    finish: &mut Finish<'_>,
    out: *mut f32,
    out_step: usize,
) {
    // SAFETY: as promised by the caller.
    unsafe {
        let out = out.add(LANES * first);
        let mut sums = [[_mm256_setzero_ps(); N]; 3];
        for (sums, r) in sums.iter_mut().zip(rows) {
            *sums = match start {
                Start::Zero => [_mm256_setzero_ps(); N],
                Start::Kept => load::<N>(out.add(r * out_step)),
                Start::Bias(bias) => load::<N>(bias.as_ptr().add(LANES * first)),
            };
        }
        let [mut a, mut b, mut c] = rows.map(|r| p.values.as_ptr().wrapping_add(r * p.steps[0]));
        let mut w = p.weights.as_ptr().add(LANES * first);
        for _ in 0..p.terms {
            let v = [_mm256_broadcast_ss(&*a), _mm256_broadcast_ss(&*b), _mm256_broadcast_ss(&*c)];
            for k in 0..N {
                let w = _mm256_loadu_ps(w.add(LANES * k));
                for (sums, v) in sums.iter_mut().zip(v) {
                    sums[k] = _mm256_fmadd_ps(v, w, sums[k]);
                }
            }
            // Beyond the last term nothing is read.
            (a, b, c) = (a.wrapping_add(p.steps[1]), b.wrapping_add(p.steps[1]), c.wrapping_add(p.steps[1]));
            w = w.wrapping_add(p.weight_step);
        }
        for (mut sums, r) in sums.into_iter().zip(rows) {
            close(&mut sums, finish, r, first);
            for (k, s) in sums.into_iter().enumerate() {
                _mm256_storeu_ps(out.add(r * out_step + LANES * k), s);
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

/// Bytes to floats times `scale`, eight at a time, and a bit for each byte that is not zero.
///
/// # Safety
/// `bytes` and `out` must be as long as `eights` times eight, `masks` have a word for every
/// eight of these.
#[target_feature(enable = "avx2")]
pub unsafe fn unpack(bytes: *const i8, eights: usize, scale: f32, out: *mut f32, masks: *mut u64) {
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
