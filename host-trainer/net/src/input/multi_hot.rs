//! The input layer on observations in cells: of 1,116 inputs some twenty are ones and the rest
//! zeros, so a sample is a list of the ones and the layer a sum of so many rows of weights.

use crate::kernel::{Epilogue, Init, LANES, Product, Vectorised, vectorised};
use crate::matrix::{Panels, Rows};
use firmware_core::observation::cells::{Cells, VELOCITY};

/// A vector of the kernel.
type Lane = [f32; LANES];

/// Samples as lists of the inputs that are one; two more inputs are plain numbers.
#[derive(Clone, Debug)]
pub struct MultiHotRows {
    /// Inputs.
    width: usize,
    /// Inputs that are one, sample by sample; an input that is listed twice is two.
    active: Vec<u16>,
    /// Where the list of each sample ends.
    ends: Vec<u32>,
    /// Inputs [`VELOCITY`] and the next of each sample.
    velocity: Vec<[f32; 2]>,
}

impl MultiHotRows {
    /// No samples yet, of `width` inputs each.
    pub const fn new(width: usize) -> Self {
        Self { width, active: Vec::new(), ends: Vec::new(), velocity: Vec::new() }
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.active.clear();
        self.ends.clear();
        self.velocity.clear();
    }

    /// Adds a sample.
    pub fn push(&mut self, cells: &Cells) {
        self.active.extend_from_slice(cells.active());
        self.ends.push(self.active.len() as u32);
        self.velocity.push(cells.velocity().map(|v| f32::from(v) * (1.0 / 127.0)));
    }

    /// How many inputs of all samples are not zero.
    pub fn nonzeros(&self) -> u64 {
        let moving = self.velocity.as_flattened().iter().filter(|v| **v != 0.0).count();
        (self.active.len() + moving) as u64
    }

    /// Each sample's ones and velocity.
    #[inline(always)]
    fn samples(&self) -> impl Iterator<Item = (&[u16], [f32; 2])> {
        let mut first = 0;
        self.ends.iter().zip(&self.velocity).map(move |(&end, &velocity)| {
            let list = &self.active[first..end as usize];
            first = end as usize;
            (list, velocity)
        })
    }
}

/// `out = relu(bias + x·w)`, a row a sample, with masks for what is not zero. Terms are added
/// in the order of the lists, the velocity first.
///
/// # Panics
/// When shapes do not fit.
pub fn multi_hot_matmul(x: &MultiHotRows, w: &Panels, bias: &[f32], out: &mut Rows) {
    assert!(w.shape() == (x.width, out.width()), "weights of {:?}, inputs of {}", w.shape(), x.width);
    out.resize(x.ends.len());
    let (stride, words) = (out.stride(), out.words());
    let (values, masks) = out.values_and_masks_mut();
    for (first, at, width) in w.panels() {
        vectorised(Gather {
            x,
            weights: w.values()[at..][..x.width * width].as_chunks().0,
            bias: bias[first..][..width].as_chunks().0,
            out: &mut values[first..],
            stride,
        });
        // A sum of no terms more, for the kernel's ReLU and masks.
        let sums = Product {
            rows: x.ends.len(),
            terms: 0,
            columns: width,
            values: &[],
            steps: [0; 2],
            masks: &[],
            mask_step: 0,
            weights: &[],
            weight_step: 0,
        };
        let relu = Epilogue::Relu { masks: &mut masks[first / 64..], step: words };
        sums.run(Init::Accumulate, relu, &mut values[first..], stride);
    }
}

/// Adds `xᵀ·g` to `sum`: the gradient of weights by their inputs and the gradient at their
/// outputs.
///
/// # Panics
/// When shapes do not fit.
pub fn add_multi_hot_gradient(x: &MultiHotRows, g: &Rows, sum: &mut Panels) {
    assert!(sum.shape() == (x.width, g.width()) && g.rows() == x.ends.len(), "shapes of a weight gradient");
    for (first, at, width) in sum.panels() {
        vectorised(Scatter {
            x,
            gradients: &g.values()[first..],
            stride: g.stride(),
            sum: sum.values_mut()[at..][..x.width * width].as_chunks_mut().0,
            lanes: width / LANES,
        });
    }
}

/// Calls `$function::<N>` with as many vectors as there are, 1 to 8.
macro_rules! by_lanes {
    ($lanes:expr, $function:ident($($argument:expr),*)) => {
        match $lanes {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            3 => $function::<3>($($argument),*),
            4 => $function::<4>($($argument),*),
            5 => $function::<5>($($argument),*),
            6 => $function::<6>($($argument),*),
            7 => $function::<7>($($argument),*),
            _ => $function::<8>($($argument),*),
        }
    };
}

struct Gather<'a> {
    x: &'a MultiHotRows,
    weights: &'a [Lane],
    bias: &'a [Lane],
    out: &'a mut [f32],
    stride: usize,
}

impl Vectorised for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        by_lanes!(self.bias.len(), gather_rows(self));
    }
}

#[inline(always)]
fn gather_rows<const N: usize>(g: Gather<'_>) {
    let (weights, _) = g.weights.as_chunks::<N>();
    let bias: [Lane; N] = std::array::from_fn(|k| g.bias[k]);
    for ((list, velocity), out) in g.x.samples().zip(g.out.chunks_mut(g.stride)) {
        let mut sums = bias;
        for (k, v) in velocity.into_iter().enumerate() {
            add_scaled(&mut sums, v, &weights[VELOCITY + k]);
        }
        for &i in list {
            add(&mut sums, &weights[usize::from(i)]);
        }
        let (out, _) = out.as_chunks_mut::<LANES>();
        out.iter_mut().zip(sums).for_each(|(to, s)| *to = s);
    }
}

struct Scatter<'a> {
    x: &'a MultiHotRows,
    gradients: &'a [f32],
    stride: usize,
    sum: &'a mut [Lane],
    lanes: usize,
}

impl Vectorised for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        by_lanes!(self.lanes, scatter_rows(self));
    }
}

#[inline(always)]
fn scatter_rows<const N: usize>(s: Scatter<'_>) {
    let (sum, _) = s.sum.as_chunks_mut::<N>();
    for ((list, velocity), g) in s.x.samples().zip(s.gradients.chunks(s.stride)) {
        let (g, _) = g.as_chunks::<LANES>();
        let g: [Lane; N] = std::array::from_fn(|k| g[k]);
        for (k, v) in velocity.into_iter().enumerate() {
            add_scaled(&mut sum[VELOCITY + k], v, &g);
        }
        for &i in list {
            add(&mut sum[usize::from(i)], &g);
        }
    }
}

#[inline(always)]
fn add<const N: usize>(sums: &mut [Lane; N], x: &[Lane; N]) {
    for (sums, x) in sums.iter_mut().zip(x) {
        sums.iter_mut().zip(x).for_each(|(s, x)| *s += x);
    }
}

#[inline(always)]
fn add_scaled<const N: usize>(sums: &mut [Lane; N], scale: f32, x: &[Lane; N]) {
    for (sums, x) in sums.iter_mut().zip(x) {
        sums.iter_mut().zip(x).for_each(|(s, x)| *s = scale.mul_add(*x, *s));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{Activation, add_weight_gradient, matmul};
    use firmware_core::observation::{BuildObservation, cells};
    use proptest::prelude::*;

    /// Some inputs only, so that others repeat and dense rows can hold them.
    const INPUTS: usize = 40;

    fn sample() -> impl Strategy<Value = (Vec<u16>, [i8; 2])> {
        let one = (0..INPUTS as u16).prop_filter("velocity", |i| !(24..26).contains(i));
        (prop::collection::vec(one, 0..cells::MAX_ACTIVE), any::<[i8; 2]>())
    }

    proptest! {
        #[test]
        fn lists_give_what_dense_rows_give(
            samples in prop::collection::vec(sample(), 1..9),
            columns in 1usize..=128,
            noise in prop::collection::vec(-1.0f32..1.0, 300),
        ) {
            let number = |k: usize| noise[k % 299] * noise[k / 299 % 300];
            let (mut lists, mut dense) = (MultiHotRows::new(INPUTS), Rows::new(INPUTS));
            dense.resize(samples.len());
            dense.values_mut().fill(0.0);
            let stride = dense.stride();
            for (r, (ones, velocity)) in samples.iter().enumerate() {
                let cells = Cells::new(*velocity, ones.iter().copied());
                lists.push(&cells);
                let row = &mut dense.values_mut()[r * stride..][..INPUTS];
                ones.iter().for_each(|&i| row[usize::from(i)] += 1.0);
                let [x, y] = cells.velocity().map(|v| f32::from(v) / 127.0);
                (row[VELOCITY], row[VELOCITY + 1]) = (x, y);
            }
            dense.update_masks();
            let (mut w, flat) = (Panels::zeros(INPUTS, columns), (0..INPUTS * columns).map(number).collect::<Vec<_>>());
            w.load(&flat);
            let mut bias = vec![0.0; columns.next_multiple_of(LANES)];
            bias[..columns].iter_mut().enumerate().for_each(|(k, b)| *b = number(k + 7));
            let (mut got, mut expected) = (Rows::new(columns), Rows::new(columns));
            multi_hot_matmul(&lists, &w, &bias, &mut got);
            matmul(&dense, &w, Init::Bias(&bias), Activation::Relu, &mut expected);
            for r in 0..samples.len() {
                for (a, b) in got.row(r).iter().zip(expected.row(r)) {
                    prop_assert!((a - b).abs() < 1e-4, "row {r}: {a}, not {b}");
                    prop_assert!(*a >= 0.0);
                }
            }
            // The masks name what is above zero.
            let nonzeros = (0..samples.len()).flat_map(|r| got.row(r)).filter(|v| **v > 0.0).count();
            prop_assert_eq!(got.nonzeros(), nonzeros as u64);
            // The backward pass.
            let mut g = Rows::new(columns);
            g.resize(samples.len());
            let stride = g.stride();
            g.values_mut().fill(0.0);
            g.values_mut().chunks_mut(stride).enumerate().for_each(|(r, row)| {
                row[..columns].iter_mut().enumerate().for_each(|(c, v)| *v = number(r * 131 + c));
            });
            let (mut sum, mut expected) = (w.clone(), w.clone());
            add_multi_hot_gradient(&lists, &g, &mut sum);
            add_weight_gradient(&dense, &g, &mut expected);
            for (a, b) in sum.values().iter().zip(expected.values()) {
                prop_assert!((a - b).abs() < 1e-3, "{a}, not {b}");
            }
        }
    }

    #[test]
    fn samples_are_counted_without_their_zeros() {
        let mut rows = MultiHotRows::new(Cells::LEN);
        rows.push(&Cells::new([0, 5], [1, 2, 2]));
        rows.push(&Cells::ZERO);
        assert_eq!(rows.nonzeros(), 4);
        rows.clear();
        assert_eq!(rows.nonzeros(), 0);
    }
}
