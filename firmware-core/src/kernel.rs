//! Dense int8 products over weights packed in row pairs.
//!
//! A layer of R rows and C columns (both padded to even with zeros) is stored as
//! R/2 pairs of C little-endian half words `256·a + (b + 128)`, where `a` and `b` are
//! the weights of rows 2p and 2p+1 in that column: one byte a weight, in the order
//! in which a dual 16-bit multiplier wants them.

/// Adds up one layer: `acc[r] = Σ_c w[r][c]·x[c]`.
///
/// `acc` has one place a row (even), `x` one value a column (even), each −128 to
/// 127; `weights` has `acc.len()·x.len()` bytes. With at most 511 columns no sum
/// leaves `i32`: |w·x| ≤ 2¹⁴, so |Σ| < 2²³.
pub fn dense(weights: &[u8], x: &[i16], acc: &mut [i32]) {
    let pair_bytes = 2 * x.len();
    if pair_bytes == 0 {
        acc.fill(0);
        return;
    }
    for (pair, out) in weights.chunks_exact(pair_bytes).zip(acc.chunks_exact_mut(2)) {
        let (mut a, mut b) = (0i32, 0i32);
        for (w, &x) in pair.chunks_exact(2).zip(x) {
            if let &[low, high] = w {
                a += i32::from(high as i8) * i32::from(x);
                b += i32::from((low ^ 0x80) as i8) * i32::from(x);
            }
        }
        if let [first, second] = out {
            *first = a;
            *second = b;
        }
    }
}

/// `round(acc·m / 2³²)`, halves up: one SMMULR on Cortex-M.
#[inline]
#[must_use]
pub fn requantise(acc: i32, m: i32) -> i32 {
    ((i64::from(acc) * i64::from(m) + (1 << 31)) >> 32) as i32
}

/// Packs two rows' weights of one column, as [`dense`] reads them.
#[must_use]
pub const fn pack(a: i8, b: i8) -> [u8; 2] {
    [b as u8 ^ 0x80, a as u8]
}
