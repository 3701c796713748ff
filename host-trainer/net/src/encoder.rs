//! The encoder: two layers with ReLU, of the actor and of the critic alike.

use crate::dense::{Dense, First, Gradient};
use crate::inputs::{InputRows, Inputs};
use crate::matrix::{Rows, To};
use crate::parameter_layout::ParameterLayout;

/// Its weights.
#[derive(Clone, Debug)]
pub struct Encoder {
    first: First,
    second: Dense,
}

/// Its activations, and gradients on the way back.
#[derive(Clone, Debug)]
pub struct EncoderPass {
    /// First hidden layer.
    pub hidden: Rows,
    /// Feature.
    pub feature: Rows,
    /// Gradient by `feature`.
    pub by_feature: Rows,
    by_hidden: Rows,
}

/// Its gradient.
#[derive(Clone, Debug)]
pub struct EncoderGradient {
    pieces: [Gradient; 4],
}

impl Encoder {
    /// The encoder in this layout.
    pub fn new(layout: &ParameterLayout) -> Self {
        Self { first: First::new(layout, "encoder1"), second: Dense::new(layout, "encoder2") }
    }

    /// Takes the parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        self.first.load(layout, values);
        self.second.load(layout, values);
    }
}

impl EncoderPass {
    /// For the encoder in this layout.
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
        encoder.first.forward(inputs.seen(), &mut self.hidden);
        encoder.second.forward(&self.hidden, To::Relu, &mut self.feature);
    }

    /// Multiply-adds of marked numbers, forward and backward.
    pub fn work(&self, inputs: &Inputs) -> [u64; 2] {
        let (hidden, feature) = (self.hidden.width() as u64, self.feature.width() as u64);
        let first = hidden
            * match inputs.seen() {
                InputRows::Numbers(rows) => rows.marked(),
                InputRows::Active(rows) => rows.marked(),
            };
        let second = self.hidden.marked() * feature;
        [first + second, first + second + self.feature.marked() * hidden]
    }

    /// Carries `by_feature`, already gated by the feature's ReLU, back to the weights.
    pub fn backward(&mut self, encoder: &Encoder, inputs: &Inputs, sum: &mut EncoderGradient) {
        let [first, first_bias, second, second_bias] = &mut sum.pieces;
        second.add_weights(&self.hidden, &self.by_feature);
        second_bias.add_bias(&self.by_feature);
        encoder.second.backward(&self.by_feature, To::Gate(&self.hidden), &mut self.by_hidden);
        match inputs.seen() {
            InputRows::Numbers(rows) => first.add_weights(rows, &self.by_hidden),
            InputRows::Active(rows) => first.add_active(rows, &self.by_hidden),
        }
        first_bias.add_bias(&self.by_hidden);
    }
}

impl EncoderGradient {
    /// Zero.
    pub fn new(layout: &ParameterLayout) -> Self {
        let weights = |name| Gradient::of_weights(layout, name);
        let bias = |name| Gradient::of_bias(layout, name);
        Self { pieces: [weights("encoder1"), bias("encoder1"), weights("encoder2"), bias("encoder2")] }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.pieces.iter_mut().for_each(Gradient::clear);
    }

    /// Writes it to its places in a flat vector.
    pub fn store(&self, layout: &ParameterLayout, out: &mut [f32]) {
        self.pieces.iter().for_each(|p| p.store(layout, out));
    }
}
