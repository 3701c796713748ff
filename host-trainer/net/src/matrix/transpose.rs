//! Bit masks by column from bit masks by row.

use crate::kernel::Vectorised;

/// Writes, for up to 64 rows, a word for every column with a bit for every row.
pub struct ColumnMasks<'a> {
    /// Masks of the rows, `words` a row.
    pub masks: &'a [u64],
    /// Words of a row's mask.
    pub words: usize,
    /// A word for every column, 64 for every word of a row's mask.
    pub columns: &'a mut [[u64; 64]],
}

impl Vectorised for ColumnMasks<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (w, columns) in self.columns.iter_mut().enumerate().take(self.words) {
            columns.iter_mut().zip(self.masks.iter().skip(w).step_by(self.words)).for_each(|(c, m)| *c = *m);
            transpose(columns);
        }
    }
}

/// Transposes 64 × 64 bits (Warren, Hacker's Delight, 7–3).
#[inline(always)]
fn transpose(words: &mut [u64; 64]) {
    swap_halves::<32>(words, 0x0000_0000_ffff_ffff);
    swap_halves::<16>(words, 0x0000_ffff_0000_ffff);
    swap_halves::<8>(words, 0x00ff_00ff_00ff_00ff);
    swap_halves::<4>(words, 0x0f0f_0f0f_0f0f_0f0f);
    swap_halves::<2>(words, 0x3333_3333_3333_3333);
    swap_halves::<1>(words, 0x5555_5555_5555_5555);
}

/// Exchanges the upper halves of the first `N` words with the lower halves of the next `N`,
/// in every `2N` bits of every `2N` words.
#[inline(always)]
fn swap_halves<const N: usize>(words: &mut [u64; 64], mask: u64) {
    for block in words.chunks_exact_mut(2 * N) {
        let (first, second) = block.split_at_mut(N);
        for (a, b) in first.iter_mut().zip(second) {
            let swap = ((*a >> N) ^ *b) & mask;
            *a ^= swap << N;
            *b ^= swap;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_change_places() {
        let mut words = std::array::from_fn(|k| (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let before: [u64; 64] = words;
        transpose(&mut words);
        for (r, row) in before.iter().enumerate() {
            for (c, column) in words.iter().enumerate() {
                assert_eq!(row >> c & 1, column >> r & 1, "{r} {c}");
            }
        }
    }
}
