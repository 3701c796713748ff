//! The encoder: two layers with ReLU, of the actor and of the critic alike.

use super::block_gradient::BlockGradient;
use super::dense::Dense;
use super::input_layer::InputLayer;
use crate::input::{InputRows, Inputs};
use crate::matrix::{Activation, Rows};
use crate::parameter_layout::ParameterLayout;

/// The encoder's weights.
#[derive(Clone, Debug)]
pub struct Encoder {
    first: InputLayer,
    second: Dense,
}

/// The encoder's activations of a micro-batch and, after the backward pass, the gradients by them.
#[derive(Clone, Debug)]
pub struct EncoderPass {
    /// First hidden layer, a row a UAV.
    pub hidden: Rows,
    /// Feature h, a row a UAV.
    pub feature: Rows,
    /// Gradient by `feature`, to be set before the backward pass.
    pub by_feature: Rows,
    by_hidden: Rows,
}

/// Gradient of the loss by the encoder's parameters: a sum over samples.
#[derive(Clone, Debug)]
pub struct EncoderGradient {
    blocks: [BlockGradient; 4],
}

impl Encoder {
    /// The encoder of a network of this layout; zeros until parameters are loaded.
    pub fn new(layout: &ParameterLayout) -> Self {
        Self { first: InputLayer::new(layout, "encoder1"), second: Dense::new(layout, "encoder2") }
    }

    /// Takes the network's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.first.load(layout, values);
        self.second.load(layout, values);
    }
}

impl EncoderPass {
    /// For the encoder of a network of this layout.
    pub fn new(layout: &ParameterLayout) -> Self {
        let rows = |name| Rows::new(layout.shape(name).1);
        Self {
            hidden: rows("encoder1"),
            feature: rows("encoder2"),
            by_feature: rows("encoder2"),
            by_hidden: rows("encoder1"),
        }
    }

    /// Computes the features.
    pub fn forward(&mut self, encoder: &Encoder, inputs: &Inputs) {
        encoder.first.forward(inputs.rows(), &mut self.hidden);
        encoder.second.forward(&self.hidden, Activation::Relu, &mut self.feature);
    }

    /// Multiply-adds in products, those with a zero left out: of the forward and of the backward
    /// pass.
    pub fn multiply_adds(&self, inputs: &Inputs) -> [u64; 2] {
        let (hidden, feature) = (self.hidden.width() as u64, self.feature.width() as u64);
        let first = hidden
            * match inputs.rows() {
                InputRows::Dense(rows) => rows.nonzeros(),
                InputRows::MultiHot(rows) => rows.nonzeros(),
            };
        let second = self.hidden.nonzeros() * feature;
        [first + second, first + second + self.feature.nonzeros() * hidden]
    }

    /// Carries `by_feature`, already gated by the feature's ReLU, back to the weights.
    pub fn backward(&mut self, encoder: &Encoder, inputs: &Inputs, sum: &mut EncoderGradient) {
        let [first, first_bias, second, second_bias] = &mut sum.blocks;
        second.add_weights(&self.hidden, &self.by_feature);
        second_bias.add_bias(&self.by_feature);
        encoder.second.backward(&self.by_feature, Activation::ReluGradient(&self.hidden), &mut self.by_hidden);
        match inputs.rows() {
            InputRows::Dense(rows) => first.add_weights(rows, &self.by_hidden),
            InputRows::MultiHot(rows) => first.add_multi_hot(rows, &self.by_hidden),
        }
        first_bias.add_bias(&self.by_hidden);
    }
}

impl EncoderGradient {
    /// Zero, for the encoder of a network of this layout.
    pub fn new(layout: &ParameterLayout) -> Self {
        let weights = |name| BlockGradient::of_weights(layout, name);
        let bias = |name| BlockGradient::of_bias(layout, name);
        Self { blocks: [weights("encoder1"), bias("encoder1"), weights("encoder2"), bias("encoder2")] }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.blocks.iter_mut().for_each(BlockGradient::clear);
    }

    /// Writes it to its places in the flat gradient of the network.
    pub fn store(&self, layout: &ParameterLayout, out: &mut [f32]) {
        self.blocks.iter().for_each(|b| b.store(layout, out));
    }
}
