//! Fully connected layers.

use super::block_gradient::bias_name;
use crate::kernel::{Aligned, Init, padded};
use crate::matrix::{Activation, Panels, Rows, matmul};
use crate::parameter_layout::ParameterLayout;

/// Weights, and their transpose for the backward pass.
#[derive(Clone, Debug)]
pub struct Weights {
    name: &'static str,
    forward: Panels,
    backward: Panels,
}

impl Weights {
    /// The block of this name; zeros until parameters are loaded.
    ///
    /// # Panics
    /// When the layout has no such block.
    pub fn new(layout: &ParameterLayout, name: &'static str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name, forward: Panels::zeros(inputs, outputs), backward: Panels::zeros(outputs, inputs) }
    }

    /// Takes the block's numbers from a network's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        let flat = layout.block(values, self.name);
        self.forward.load(flat);
        self.backward.load_transposed(flat);
    }

    /// `out = activation(init + x·w)`.
    pub fn forward(&self, x: &Rows, init: Init<'_>, activation: Activation<'_>, out: &mut Rows) {
        matmul(x, &self.forward, init, activation, out);
    }

    /// `out = activation(init + g·wᵀ)`: the gradient by the inputs from that by the outputs.
    pub fn backward(&self, g: &Rows, init: Init<'_>, activation: Activation<'_>, out: &mut Rows) {
        matmul(g, &self.backward, init, activation, out);
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
    /// The bias of the weights of this name; zeros until parameters are loaded.
    pub fn new(layout: &ParameterLayout, name: &str) -> Self {
        let name = bias_name(name);
        let (_, width) = layout.shape(&name);
        Self { name, values: Aligned::zeros(padded(width)), width }
    }

    /// Takes the block's numbers from a network's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.values[..self.width].copy_from_slice(layout.block(values, &self.name));
    }

    /// The bias as what sums start from.
    pub fn init(&self) -> Init<'_> {
        Init::Bias(&self.values)
    }

    /// The numbers, padded.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

/// Weights with a bias.
#[derive(Clone, Debug)]
pub struct Dense {
    weights: Weights,
    bias: Bias,
}

impl Dense {
    /// The block of this name and its bias; zeros until parameters are loaded.
    pub fn new(layout: &ParameterLayout, name: &'static str) -> Self {
        Self { weights: Weights::new(layout, name), bias: Bias::new(layout, name) }
    }

    /// Takes the blocks' numbers from a network's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.weights.load(layout, values);
        self.bias.load(layout, values);
    }

    /// The weights alone.
    pub const fn weights(&self) -> &Weights {
        &self.weights
    }

    /// `out = activation(b + x·w)`.
    pub fn forward(&self, x: &Rows, activation: Activation<'_>, out: &mut Rows) {
        self.weights.forward(x, self.bias.init(), activation, out);
    }

    /// `out = activation(g·wᵀ)`: the gradient by the inputs from that by the outputs.
    pub fn backward(&self, g: &Rows, activation: Activation<'_>, out: &mut Rows) {
        self.weights.backward(g, Init::Zero, activation, out);
    }
}
