//! The first layer of the encoder.

use super::dense::Bias;
use crate::input::{InputRows, multi_hot_matmul};
use crate::matrix::{Activation, Panels, Rows, matmul};
use crate::parameter_layout::ParameterLayout;

/// Weights, bias and ReLU of the input layer. No gradient goes back through it, so there is no
/// transpose.
#[derive(Clone, Debug)]
pub struct InputLayer {
    name: &'static str,
    weights: Panels,
    bias: Bias,
}

impl InputLayer {
    /// The block of this name and its bias; zeros until parameters are loaded.
    pub fn new(layout: &ParameterLayout, name: &'static str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name, weights: Panels::zeros(inputs, outputs), bias: Bias::new(layout, name) }
    }

    /// Takes the blocks' numbers from a network's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.weights.load(layout.block(values, self.name));
        self.bias.load(layout, values);
    }

    /// `out = relu(b + x·w)`.
    pub fn forward(&self, x: &InputRows, out: &mut Rows) {
        match x {
            InputRows::Dense(rows) => matmul(rows, &self.weights, self.bias.init(), Activation::Relu, out),
            InputRows::MultiHot(rows) => multi_hot_matmul(rows, &self.weights, self.bias.values(), out),
        }
    }
}
