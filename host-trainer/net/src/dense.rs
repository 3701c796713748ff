//! Fully connected layers.

use crate::active::{ActiveRows, add_active, gather};
use crate::inputs::InputRows;
use crate::kernel::Aligned;
use crate::matrix::{From, Panels, Rows, To, add_outer, add_rows, multiply};
use crate::parameter_layout::ParameterLayout;

/// Name of the bias that goes with a piece.
fn bias_of(name: &str) -> String {
    format!("{name} bias")
}

/// Weights, and their transpose for the way back.
#[derive(Clone, Debug)]
pub struct Weights {
    name: &'static str,
    forward: Panels,
    backward: Panels,
}

impl Weights {
    /// The piece of this name.
    ///
    /// # Panics
    /// When the layout has none.
    pub fn new(layout: &ParameterLayout, name: &'static str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name, forward: Panels::zeros(inputs, outputs), backward: Panels::zeros(outputs, inputs) }
    }

    /// Takes the piece's numbers.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        let flat = layout.piece(values, self.name);
        self.forward.load(flat);
        self.backward.load_transposed(flat);
    }

    /// `out = to(from + x·w)`.
    pub fn forward(&self, x: &Rows, from: From<'_>, to: To<'_>, out: &mut Rows) {
        multiply(x, &self.forward, from, to, out);
    }

    /// `out = to(from + g·wᵀ)`.
    pub fn backward(&self, g: &Rows, from: From<'_>, to: To<'_>, out: &mut Rows) {
        multiply(g, &self.backward, from, to, out);
    }
}

/// A bias, padded to whole vectors.
#[derive(Clone, Debug)]
pub struct Bias {
    name: String,
    values: Aligned,
    width: usize,
}

impl Bias {
    /// The bias of the piece of this name.
    pub fn new(layout: &ParameterLayout, name: &str) -> Self {
        let name = bias_of(name);
        let (_, width) = layout.shape(&name);
        Self { name, values: Aligned::zeros(crate::kernel::padded(width)), width }
    }

    /// Takes the piece's numbers.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.values[..self.width].copy_from_slice(layout.piece(values, &self.name));
    }

    /// As what sums start from.
    pub fn start(&self) -> From<'_> {
        From::Bias(&self.values)
    }
}

/// Weights with a bias.
#[derive(Clone, Debug)]
pub struct Dense {
    weights: Weights,
    bias: Bias,
}

impl Dense {
    /// The piece of this name and its bias.
    pub fn new(layout: &ParameterLayout, name: &'static str) -> Self {
        Self { weights: Weights::new(layout, name), bias: Bias::new(layout, name) }
    }

    /// Takes the pieces' numbers.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.weights.load(layout, values);
        self.bias.load(layout, values);
    }

    /// `out = to(b + x·w)`.
    pub fn forward(&self, x: &Rows, to: To<'_>, out: &mut Rows) {
        self.weights.forward(x, self.bias.start(), to, out);
    }

    /// `out = to(g·wᵀ)`.
    pub fn backward(&self, g: &Rows, to: To<'_>, out: &mut Rows) {
        self.weights.backward(g, From::Zero, to, out);
    }
}

/// The first layer: nothing is carried back through it, so there is no transpose.
#[derive(Clone, Debug)]
pub struct First {
    name: &'static str,
    weights: Panels,
    bias: Bias,
}

impl First {
    /// The piece of this name and its bias.
    pub fn new(layout: &ParameterLayout, name: &'static str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name, weights: Panels::zeros(inputs, outputs), bias: Bias::new(layout, name) }
    }

    /// Takes the pieces' numbers.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.weights.load(layout.piece(values, self.name));
        self.bias.load(layout, values);
    }

    /// `out = relu(b + x·w)`.
    pub fn forward(&self, x: &InputRows, out: &mut Rows) {
        match x {
            InputRows::Numbers(rows) => multiply(rows, &self.weights, self.bias.start(), To::Relu, out),
            InputRows::Active(rows) => gather(rows, &self.weights, &self.bias.values, out),
        }
    }
}

/// Gradient of a piece: sums over samples.
#[derive(Clone, Debug)]
pub struct Gradient {
    name: String,
    sum: Panels,
    transposed: bool,
}

impl Gradient {
    /// Of the weights of this name.
    pub fn of_weights(layout: &ParameterLayout, name: &str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name: name.to_owned(), sum: Panels::zeros(inputs, outputs), transposed: false }
    }

    /// Of weights with few outputs: summed the other way round, which keeps the kernel's
    /// rows long.
    pub fn of_narrow_weights(layout: &ParameterLayout, name: &str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name: name.to_owned(), sum: Panels::zeros(outputs, inputs), transposed: true }
    }

    /// Of the bias of the piece of this name.
    pub fn of_bias(layout: &ParameterLayout, name: &str) -> Self {
        Self::of_weights(layout, &bias_of(name))
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.sum.clear();
    }

    /// Adds that of weights with inputs `x` and gradient `g` at their outputs.
    pub fn add_weights(&mut self, x: &Rows, g: &Rows) {
        if self.transposed {
            add_outer(g, x, &mut self.sum);
        } else {
            add_outer(x, g, &mut self.sum);
        }
    }

    /// Adds that of weights whose inputs are listed, with gradient `g` at their outputs.
    pub fn add_active(&mut self, x: &ActiveRows, g: &Rows) {
        add_active(x, g, &mut self.sum);
    }

    /// Adds that of a bias with gradient `g` at its outputs.
    pub fn add_bias(&mut self, g: &Rows) {
        add_rows(g, &mut self.sum);
    }

    /// Writes it to its place in a flat vector.
    pub fn store(&self, layout: &ParameterLayout, out: &mut [f32]) {
        let place = layout.piece_mut(out, &self.name);
        if self.transposed {
            self.sum.store_transposed(place);
        } else {
            self.sum.store(place);
        }
    }
}
