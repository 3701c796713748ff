//! Gradients of weights and biases.

use crate::input::{MultiHotRows, add_multi_hot_gradient};
use crate::matrix::{Panels, Rows, add_bias_gradient, add_weight_gradient};
use crate::parameter_layout::ParameterLayout;

/// Gradient of the loss by a block of parameters: a sum over samples.
#[derive(Clone, Debug)]
pub struct BlockGradient {
    name: String,
    sum: Panels,
    transposed: bool,
}

impl BlockGradient {
    /// Zero, for the weights of this name.
    pub fn of_weights(layout: &ParameterLayout, name: &str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name: name.to_owned(), sum: Panels::zeros(inputs, outputs), transposed: false }
    }

    /// Zero, for weights with few outputs: it is summed transposed, which keeps the kernel's rows
    /// long.
    pub fn of_narrow_weights(layout: &ParameterLayout, name: &str) -> Self {
        let (inputs, outputs) = layout.shape(name);
        Self { name: name.to_owned(), sum: Panels::zeros(outputs, inputs), transposed: true }
    }

    /// Zero, for the bias of the weights of this name.
    pub fn of_bias(layout: &ParameterLayout, name: &str) -> Self {
        Self::of_weights(layout, &bias_name(name))
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.sum.clear();
    }

    /// Adds the gradient by weights with inputs `x` and gradient `g` at their outputs.
    pub fn add_weights(&mut self, x: &Rows, g: &Rows) {
        if self.transposed {
            add_weight_gradient(g, x, &mut self.sum);
        } else {
            add_weight_gradient(x, g, &mut self.sum);
        }
    }

    /// Adds the gradient by weights whose inputs are multi-hot, with gradient `g` at their outputs.
    pub fn add_multi_hot(&mut self, x: &MultiHotRows, g: &Rows) {
        add_multi_hot_gradient(x, g, &mut self.sum);
    }

    /// Adds the gradient by a bias with gradient `g` at its outputs.
    pub fn add_bias(&mut self, g: &Rows) {
        add_bias_gradient(g, &mut self.sum);
    }

    /// Writes it to its place in the flat gradient of the network.
    pub fn store(&self, layout: &ParameterLayout, out: &mut [f32]) {
        let place = layout.block_mut(out, &self.name);
        if self.transposed {
            self.sum.store_transposed(place);
        } else {
            self.sum.store(place);
        }
    }
}

/// Name of the bias that goes with the weights of this name.
pub(super) fn bias_name(weights: &str) -> String {
    format!("{weights} bias")
}
