//! Running products and conversions with the instructions that this processor has.

use super::product::{Epilogue, Init, Product};
use super::simd::has_avx2;

#[cfg(target_arch = "x86_64")]
use super::avx2;

impl Product<'_> {
    /// Computes the product; row r goes to `out[r·out_step..]`.
    ///
    /// # Panics
    /// When a slice is too short for what the numbers say.
    pub fn run(&self, init: Init<'_>, epilogue: Epilogue<'_>, out: &mut [f32], out_step: usize) {
        if self.rows == 0 {
            return;
        }
        self.check(&init, &epilogue, out.len(), out_step);
        #[cfg(target_arch = "x86_64")]
        if has_avx2() {
            // SAFETY: the processor has what it takes, and `check` saw that every place is
            // within its slice.
            unsafe { avx2::run(self, init, epilogue, out.as_mut_ptr(), out_step) };
            return;
        }
        self.run_portable(init, epilogue, out, out_step);
    }
}

/// Converts a row of int8 numbers, whole eights of them, to floats times `scale`; bit k mod 64
/// of word k/64 of `masks` tells whether number k is not zero.
///
/// # Panics
/// When `out` or `masks` is too short, or the bytes are not whole eights.
pub fn dequantise(bytes: &[i8], scale: f32, out: &mut [f32], masks: &mut [u64]) {
    let (eights, rest) = bytes.as_chunks::<8>();
    assert!(rest.is_empty() && bytes.len() <= out.len() && bytes.len() <= 64 * masks.len(), "whole eights and room");
    #[cfg(target_arch = "x86_64")]
    if has_avx2() {
        // SAFETY: the processor has what it takes, and the lengths are checked above.
        unsafe { avx2::dequantise(bytes.as_ptr(), eights.len(), scale, out.as_mut_ptr(), masks.as_mut_ptr()) };
        return;
    }
    masks[..bytes.len().div_ceil(64)].fill(0);
    for (k, (x, &byte)) in out.iter_mut().zip(eights.as_flattened()).enumerate() {
        *x = f32::from(byte) * scale;
        masks[k / 64] |= u64::from(byte != 0) << (k % 64);
    }
}

#[cfg(test)]
mod tests {
    use super::dequantise;
    use crate::kernel::{Epilogue, Init, LANES, Product};
    use proptest::prelude::*;

    /// A product of random shape with its init and epilogue.
    #[derive(Clone, Debug)]
    struct Case {
        rows: usize,
        terms: usize,
        columns: usize,
        values: Vec<f32>,
        masks: Vec<u64>,
        weights: Vec<f32>,
        out: Vec<f32>,
        init: u8,
        epilogue: u8,
        /// Values term by term rather than row by row.
        across: bool,
        /// Distance between rows of weights beyond their columns.
        gap: usize,
    }

    fn case() -> impl Strategy<Value = Case> {
        let shape = (1usize..=8, 0usize..=140, 1usize..=8, 0u8..3, 0u8..3, any::<bool>(), 0usize..3);
        shape.prop_flat_map(|(rows, terms, vectors, init, epilogue, across, gap)| {
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
                    Case { rows, terms, columns, values, masks, weights, out, init, epilogue, across, gap }
                })
        })
    }

    impl Case {
        /// Output and masks, by `run` or by `run_portable`.
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
            let init = match self.init {
                0 => Init::Zero,
                1 => Init::Accumulate,
                _ => Init::Bias(&self.weights),
            };
            let epilogue = match self.epilogue {
                0 => Epilogue::Identity,
                1 => Epilogue::Relu { masks: &mut masks, step: 1 },
                _ => Epilogue::ReluGradient { outputs: &self.out, step: self.columns },
            };
            if run {
                product.run(init, epilogue, &mut out, self.columns);
            } else {
                product.run_portable(init, epilogue, &mut out, self.columns);
            }
            (out, masks)
        }

        /// A sum in double precision.
        fn exact(&self, r: usize, c: usize) -> f64 {
            let init = match self.init {
                0 => 0.0,
                1 => self.out[r * self.columns + c],
                _ => self.weights[c],
            };
            let term = |i: usize| {
                let v = self.values[if self.across { i * self.rows + r } else { r * self.terms + i }];
                f64::from(v) * f64::from(self.weights[i * (self.columns + self.gap) + c])
            };
            let sum = f64::from(init) + (0..self.terms).map(term).sum::<f64>();
            match self.epilogue {
                1 => sum.max(0.0),
                2 if self.out[r * self.columns + c] <= 0.0 => 0.0,
                _ => sum,
            }
        }
    }

    proptest! {
        #[test]
        fn bytes_are_converted(bytes in prop::collection::vec(prop_oneof![Just(0i8), any::<i8>()], 0..160)) {
            let bytes = &bytes[..bytes.len() / 8 * 8];
            let (mut floats, mut masks) = (vec![f32::NAN; bytes.len() + 3], vec![u64::MAX; bytes.len().div_ceil(64)]);
            dequantise(bytes, 0.5, &mut floats, &mut masks);
            for (k, &byte) in bytes.iter().enumerate() {
                prop_assert_eq!(floats[k], f32::from(byte) / 2.0);
                prop_assert_eq!(masks[k / 64] >> (k % 64) & 1 == 1, byte != 0);
            }
        }

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
                    if case.epilogue == 1 {
                        prop_assert_eq!(masks[r] >> c & 1 == 1, got > 0.0);
                    }
                }
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
        product.run(Init::Zero, Epilogue::Identity, &mut [0.0; 16], 8);
    }
}
