//! From float layers to int8 rows with one multiplier each.
//!
//! An activation `a_k` is kept as `round(a_k/s_k)` with a scale of its own for every
//! channel: the scales of a layer's inputs are folded into its weights, so they cost
//! nothing on board.

use super::error::QuantiseError;
use firmware_core::actor::layer::MAX_BIAS;
use firmware_core::kernel::{WIDE_SHIFT, pack};

/// Logits and attention scores are in 1/256 of a doubling: log₂e·2⁸ a nat.
pub const WIDE_UNITS: f64 = std::f64::consts::LOG2_E * 256.0;

/// A layer in floats: `weights[row][column]`, one bias a row.
pub struct FloatLayer {
    /// Name for messages.
    pub name: &'static str,
    /// Weights by row.
    pub weights: Vec<Vec<f64>>,
    /// Biases.
    pub biases: Vec<f64>,
}

impl FloatLayer {
    /// From weights `inputs × outputs` (row-major) as the trainer keeps them.
    pub fn from_columns(name: &'static str, weights: &[f32], biases: &[f32]) -> Self {
        let outputs = biases.len();
        let row = |r: usize| weights.iter().skip(r).step_by(outputs).map(|&w| f64::from(w)).collect();
        Self { name, weights: (0..outputs).map(row).collect(), biases: biases.iter().map(|&b| f64::from(b)).collect() }
    }

    /// Makes scales of signed outputs larger where no multiplier reaches them.
    pub fn widen(&self, inputs: &[f64], scales: &mut [f64]) {
        for ((row, &bias), scale) in self.weights.iter().zip(&self.biases).zip(scales) {
            let folded: Vec<f64> = row.iter().zip(inputs).map(|(w, s)| w * s).collect();
            *scale = scale.max(row_scale(&folded, bias) * 2.001 / WIDE_FACTOR);
        }
    }

    /// Puts the columns of another layer behind this one's.
    pub fn beside(mut self, weights: &[f32]) -> Self {
        let outputs = self.weights.len();
        for (r, row) in self.weights.iter_mut().enumerate() {
            row.extend(weights.iter().skip(r).step_by(outputs).map(|&w| f64::from(w)));
        }
        self
    }
}

/// Wide outputs are made of so many times the sum.
const WIDE_FACTOR: f64 = (1u32 << WIDE_SHIFT) as f64;

/// Scales of a layer's channels: ranges over 127, between the layer's (0) and each
/// channel's own (1).
pub fn scales(ranges: &[f32], own: f64) -> Vec<f64> {
    let top = ranges.iter().fold(1e-6f64, |m, &r| m.max(f64::from(r)));
    // A channel that hardly ever fires keeps a thousandth of the layer's range.
    ranges.iter().map(|&r| top * (f64::from(r).max(top * 1e-3) / top).powf(own) / 127.0).collect()
}

/// What a unit of a row's sum is, from its weights with the scales of the inputs folded in.
fn row_scale(folded: &[f64], bias: f64) -> f64 {
    let largest = folded.iter().fold(0.0f64, |m, w| m.max(w.abs()));
    // The bias must fit beside the sum; a row of zeros takes any scale.
    (largest / 127.0).max(bias.abs() / f64::from(MAX_BIAS)).max(1e-12)
}

/// The actor file's two blobs in the making.
#[derive(Default)]
pub struct Blobs {
    /// Packed weights.
    pub weights: Vec<u8>,
    /// Biases and multipliers.
    pub tables: Vec<u8>,
}

/// `factor` as a 32-bit fraction.
fn multiplier(factor: f64) -> Option<i32> {
    let m = (factor * 2f64.powi(32)).round();
    (m >= 0.0 && m <= f64::from(i32::MAX)).then_some(m as i32)
}

/// How weights lie in the file.
#[derive(Clone, Copy)]
pub enum Order {
    /// Packed in pairs of rows, as the kernel takes them.
    RowPairs,
    /// Column by column, each padded with zeros to whole eights of rows: of a layer whose inputs
    /// are mostly zero.
    Columns,
}

/// What a row's sum becomes.
pub enum Output<'s> {
    /// int8 with these scales; a scale that no multiplier reaches is made larger.
    Int8(&'s mut [f64]),
    /// 1/256 of a doubling.
    Wide,
    /// A wide output with these scales.
    Signed(&'s [f64]),
}

impl Blobs {
    /// Quantises a layer whose inputs have these scales.
    ///
    /// # Errors
    /// [`QuantiseError`] when a weight is not finite or a wide output's multiplier does
    /// not fit.
    pub fn push(&mut self, layer: &FloatLayer, inputs: &[f64], output: Output<'_>) -> Result<(), QuantiseError> {
        self.push_in(Order::RowPairs, layer, inputs, output)
    }

    /// As [`Self::push`], with its weights in this order.
    ///
    /// # Errors
    /// As there.
    pub fn push_in(
        &mut self,
        order: Order,
        layer: &FloatLayer,
        inputs: &[f64],
        mut output: Output<'_>,
    ) -> Result<(), QuantiseError> {
        let (rows, columns) = (layer.weights.len(), inputs.len());
        let (mut quantised, mut biases, mut multipliers) = (Vec::new(), Vec::new(), Vec::new());
        for (r, (row, &bias)) in layer.weights.iter().zip(&layer.biases).enumerate() {
            let folded: Vec<f64> = row.iter().zip(inputs).map(|(w, s)| w * s).collect();
            if !bias.is_finite() || folded.iter().any(|w| !w.is_finite()) {
                return Err(QuantiseError::NotFinite { layer: layer.name, row: r });
            }
            let scale = row_scale(&folded, bias);
            let factor = match &mut output {
                Output::Int8(scales) => {
                    scales[r] = scales[r].max(scale * 2.001);
                    scale / scales[r]
                }
                Output::Wide => scale * WIDE_UNITS / WIDE_FACTOR,
                Output::Signed(scales) => scale / scales[r] / WIDE_FACTOR,
            };
            let m = multiplier(factor).ok_or(QuantiseError::TooLarge { layer: layer.name, row: r })?;
            quantised.push(folded.iter().map(|w| (w / scale).round() as i8).collect::<Vec<_>>());
            biases.push((bias / scale).round() as i32);
            multipliers.push(m);
        }
        let weight = |r: usize, c: usize| quantised.get(r).and_then(|q| q.get(c)).copied().unwrap_or(0);
        match order {
            Order::RowPairs => {
                let places = (0..rows.div_ceil(2)).flat_map(|p| (0..columns + columns % 2).map(move |c| (p, c)));
                self.weights.extend(places.flat_map(|(p, c)| pack(weight(2 * p, c), weight(2 * p + 1, c))));
            }
            Order::Columns => {
                let padded = rows.next_multiple_of(8);
                let places = (0..columns).flat_map(|c| (0..padded).map(move |r| (r, c)));
                self.weights.extend(places.map(|(r, c)| weight(r, c) as u8));
            }
        }
        self.tables.extend(biases.into_iter().chain(multipliers).flat_map(i32::to_le_bytes));
        Ok(())
    }
}
