//! The products of a layer, forward and backward.

use super::panels::Panels;
use super::rows::{Rows, WIDEST};
use super::transpose::ColumnMasks;
use crate::kernel::{Epilogue, Init, LANES, PANEL, Product, vectorised};

const _: () = assert!(PANEL == 64 && PANEL.is_multiple_of(LANES), "a panel is a word of a mask wide");

/// What [`matmul`] does to the sums.
#[derive(Clone, Copy, Debug)]
pub enum Activation<'a> {
    /// Nothing; the masks are not kept up to date.
    Identity,
    /// A ReLU; the masks name what it lets through.
    Relu,
    /// The gradient of the ReLU that had this output; masks as there.
    ReluGradient(&'a Rows),
}

/// `out = activation(init + x·w)`, a row for every row of `x`, whose masks say which of its
/// numbers are not zero.
///
/// # Panics
/// When shapes do not fit.
pub fn matmul(x: &Rows, w: &Panels, init: Init<'_>, activation: Activation<'_>, out: &mut Rows) {
    assert!(w.shape() == (x.width(), out.width()), "{}·{:?}={}", x.width(), w.shape(), out.width());
    if matches!(init, Init::Accumulate) {
        assert_eq!(x.rows(), out.rows(), "rows to add to");
    } else {
        out.resize(x.rows());
    }
    if let Activation::ReluGradient(outputs) = activation {
        assert!(outputs.rows() == out.rows() && outputs.width() == out.width(), "a ReLU of the output's shape");
        out.copy_masks(outputs);
    }
    if x.rows() == 0 {
        return;
    }
    let (stride, words) = (out.stride(), out.words());
    let (values, masks) = out.values_and_masks_mut();
    for (first, at, width) in w.panels() {
        let product = Product {
            rows: x.rows(),
            terms: x.width(),
            columns: width,
            values: x.values(),
            steps: [x.stride(), 1],
            masks: x.masks(),
            mask_step: x.words(),
            weights: &w.values()[at..],
            weight_step: width,
        };
        let init = match init {
            Init::Bias(bias) => Init::Bias(&bias[first..]),
            other => other,
        };
        let epilogue = match activation {
            Activation::Identity => Epilogue::Identity,
            Activation::Relu => Epilogue::Relu { masks: &mut masks[first / 64..], step: words },
            Activation::ReluGradient(outputs) => {
                Epilogue::ReluGradient { outputs: &outputs.values()[first..], step: outputs.stride() }
            }
        };
        product.run(init, epilogue, &mut values[first..], stride);
    }
}

/// Adds `xᵀ·g` to `sum`: the gradient of weights by their inputs `x` and the gradient `g` at
/// their outputs. The masks of `x` say which of its numbers are not zero.
///
/// # Panics
/// When shapes do not fit.
pub fn add_weight_gradient(x: &Rows, g: &Rows, sum: &mut Panels) {
    assert!(x.rows() == g.rows() && sum.shape() == (x.width(), g.width()), "shapes of a weight gradient");
    for (first, rows) in chunks(x.rows()) {
        // Masks of up to 64 samples, a word an input.
        let mut columns = [[0; 64]; WIDEST / 64];
        vectorised(ColumnMasks {
            masks: &x.masks()[first * x.words()..(first + rows) * x.words()],
            words: x.words(),
            columns: &mut columns,
        });
        for (column, at, width) in sum.panels() {
            let product = Product {
                rows: x.width(),
                terms: rows,
                columns: width,
                values: &x.values()[first * x.stride()..],
                steps: [1, x.stride()],
                masks: columns.as_flattened(),
                mask_step: 1,
                weights: &g.values()[first * g.stride() + column..],
                weight_step: g.stride(),
            };
            product.run(Init::Accumulate, Epilogue::Identity, &mut sum.values_mut()[at..], width);
        }
    }
}

/// Adds the sum of the rows of `g` to `sum`, which has one row: the gradient of a bias.
///
/// # Panics
/// When shapes do not fit.
pub fn add_bias_gradient(g: &Rows, sum: &mut Panels) {
    assert!(sum.shape() == (1, g.width()), "shapes of a bias gradient");
    for (first, rows) in chunks(g.rows()) {
        for (column, at, width) in sum.panels() {
            let product = Product {
                rows: 1,
                terms: rows,
                columns: width,
                values: &[1.0],
                steps: [0, 0],
                masks: &[u64::MAX],
                mask_step: 0,
                weights: &g.values()[first * g.stride() + column..],
                weight_step: g.stride(),
            };
            product.run(Init::Accumulate, Epilogue::Identity, &mut sum.values_mut()[at..], width);
        }
    }
}

/// First row and number of rows of the parts of at most 64 rows, as even as can be.
fn chunks(rows: usize) -> impl Iterator<Item = (usize, usize)> {
    let count = rows.div_ceil(64);
    (0..count).map(move |k| (k * rows / count, (k + 1) * rows / count - k * rows / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_even() {
        assert_eq!(chunks(130).collect::<Vec<_>>(), [(0, 43), (43, 43), (86, 44)]);
        assert_eq!(chunks(64).collect::<Vec<_>>(), [(0, 64)]);
        assert_eq!(chunks(0).count(), 0);
    }
}
