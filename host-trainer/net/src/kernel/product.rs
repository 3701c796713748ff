//! The product under every layer, forward and backward.
//!
//! All products of a network are sums of rows: `out[r] = Σ_i v[r, i] · w[i]`. Forward, r is
//! a sample, i an input, w the weights; backward, w is their transpose; for weight
//! gradients r is an input and i a sample, w the gradient at the outputs. In each of them
//! many v are zero (absent neighbours and PoIs, inputs that a ReLU cut off), so a bit mask
//! names those that are not and the kernel visits only these. A visit costs one
//! broadcast and up to eight fused multiply-adds into registers.

use super::lanes::{LANES, PANEL};

/// What the sums of a row start from.
#[derive(Clone, Copy, Debug)]
pub enum Init<'a> {
    /// Zeros.
    Zero,
    /// What stands in the output: the product is added to it.
    Accumulate,
    /// The same numbers for every row, as many as columns.
    Bias(&'a [f32]),
}

/// What happens to the sums of a row before they are stored.
#[derive(Debug)]
pub enum Epilogue<'a> {
    /// Nothing.
    Identity,
    /// Negative sums become zero. Bits of those above zero go to word `r·step` for row r:
    /// bit c for column c.
    Relu {
        /// The words.
        masks: &'a mut [u64],
        /// Words from row to row.
        step: usize,
    },
    /// Sums become zero where the ReLU's output at `r·step + c` is not above zero: the sums are
    /// the gradient by that output, and become the gradient by the ReLU's input.
    ReluGradient {
        /// Outputs of the ReLU.
        outputs: &'a [f32],
        /// Numbers from row to row.
        step: usize,
    },
}

/// `out[r] = epilogue(init + Σ_i values[r, i] · weights[i])` over the i in row r's mask.
#[derive(Debug)]
pub struct Product<'a> {
    /// Rows.
    pub rows: usize,
    /// Terms of a sum.
    pub terms: usize,
    /// Columns, a multiple of [`LANES`], at most 64.
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
    /// # Panics
    /// When a slice is too short for what the numbers say.
    pub(super) fn check(&self, init: &Init<'_>, epilogue: &Epilogue<'_>, out: usize, out_step: usize) {
        let (last, columns) = (self.rows - 1, self.columns);
        let words = self.terms.div_ceil(64);
        assert!(columns > 0 && columns <= PANEL && columns.is_multiple_of(LANES), "columns in whole vectors");
        assert!(last * out_step + columns <= out, "output too short");
        assert!(last * self.mask_step + words <= self.masks.len(), "masks too short");
        if let Some(term) = self.terms.checked_sub(1) {
            assert!(last * self.steps[0] + term * self.steps[1] < self.values.len(), "values too short");
            assert!(term * self.weight_step + columns <= self.weights.len(), "weights too short");
        }
        if let Init::Bias(bias) = init {
            assert!(columns <= bias.len(), "bias too short");
        }
        match epilogue {
            Epilogue::Identity => {}
            Epilogue::Relu { masks, step } => assert!(last * step < masks.len(), "room for masks too short"),
            Epilogue::ReluGradient { outputs, step } => {
                assert!(last * step + columns <= outputs.len(), "outputs of the ReLU too short")
            }
        }
    }

    /// Mask of the terms of block `b` (64 terms) that exist.
    #[inline(always)]
    const fn limit(&self, b: usize) -> u64 {
        let left = self.terms - 64 * b;
        if left >= 64 { u64::MAX } else { (1 << left) - 1 }
    }

    /// Computes the product in code for any processor; row r goes to `out[r·out_step..]`.
    pub(super) fn run_portable(&self, init: Init<'_>, mut epilogue: Epilogue<'_>, out: &mut [f32], out_step: usize) {
        for r in 0..self.rows {
            let row = &mut out[r * out_step..][..self.columns];
            match init {
                Init::Zero => row.fill(0.0),
                Init::Accumulate => {}
                Init::Bias(bias) => row.copy_from_slice(&bias[..self.columns]),
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
            match &mut epilogue {
                Epilogue::Identity => {}
                Epilogue::Relu { masks, step } => {
                    let mut mask = 0;
                    for (c, s) in row.iter_mut().enumerate() {
                        // What is not a number stays so that it is noticed.
                        mask |= u64::from(*s > 0.0 || s.is_nan()) << c;
                        *s = if *s <= 0.0 { 0.0 } else { *s };
                    }
                    masks[r * *step] = mask;
                }
                Epilogue::ReluGradient { outputs, step } => {
                    let outputs = &outputs[r * *step..][..self.columns];
                    row.iter_mut().zip(outputs).for_each(|(s, o)| *s = if *o <= 0.0 { 0.0 } else { *s });
                }
            }
        }
    }
}
