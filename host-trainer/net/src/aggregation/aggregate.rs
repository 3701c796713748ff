//! The weighted sum over a neighbourhood, forward and backward.

use super::attention::{Attention, AttentionGradient, AttentionScores};
use super::edges::Edges;
use super::gcn::weigh_by_degree;
use super::sage::weigh_alike;
use crate::input::Inputs;
use crate::kernel::{Vectorised, vectorised};
use crate::matrix::Rows;
use crate::parameter_layout::ParameterLayout;

/// By which weights features are summed.
#[derive(Clone, Debug)]
pub enum Weighing {
    /// Those of a GCN.
    Degree,
    /// Those of `GraphSAGE`: all neighbours alike, the UAV itself not.
    Alike,
    /// Those of a GAT.
    Attention(Attention),
}

impl Weighing {
    /// Attention, if there is any.
    pub const fn attention(&self) -> Option<&Attention> {
        match self {
            Self::Attention(a) => Some(a),
            Self::Degree | Self::Alike => None,
        }
    }

    /// Takes the actor's parameters.
    pub fn load(&mut self, layout: &ParameterLayout, values: &[f32]) {
        if let Self::Attention(a) = self {
            a.load(layout, values);
        }
    }
}

/// The edges of a micro-batch with their weights, kept from the forward to the backward pass.
#[derive(Clone, Debug, Default)]
pub struct Aggregate {
    edges: Edges,
    scores: AttentionScores,
}

impl Aggregate {
    /// `combined[i] = Σ_j weight_ij · feature[j]` over each UAV itself and its neighbours.
    pub fn forward(&mut self, inputs: &Inputs, weighing: &Weighing, feature: &Rows, combined: &mut Rows) {
        combined.resize(feature.rows());
        vectorised(Forward { aggregate: self, inputs, weighing, feature, combined });
        // Hardly any are zero.
        combined.fill_masks();
    }

    /// Writes the gradient by the features to `by_feature` and adds that by attention's
    /// parameters.
    pub fn backward(
        &mut self,
        by_combined: &Rows,
        feature: &Rows,
        attention: Option<(&Attention, &mut AttentionGradient)>,
        by_feature: &mut Rows,
    ) {
        by_feature.resize(feature.rows());
        vectorised(Backward { aggregate: self, by_combined, feature, attention, by_feature });
    }
}

struct Forward<'a> {
    aggregate: &'a mut Aggregate,
    inputs: &'a Inputs,
    weighing: &'a Weighing,
    feature: &'a Rows,
    combined: &'a mut Rows,
}

impl Vectorised for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Aggregate { edges, scores } = self.aggregate;
        edges.list(self.inputs);
        match self.weighing {
            Weighing::Degree => weigh_by_degree(edges, self.inputs.neighbours()),
            Weighing::Alike => weigh_alike(edges),
            Weighing::Attention(attention) => scores.weigh(edges, attention, self.feature),
        }
        edges.combine(self.feature, self.combined);
    }
}

struct Backward<'a> {
    aggregate: &'a mut Aggregate,
    by_combined: &'a Rows,
    feature: &'a Rows,
    attention: Option<(&'a Attention, &'a mut AttentionGradient)>,
    by_feature: &'a mut Rows,
}

impl Vectorised for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { aggregate: Aggregate { edges, scores }, by_combined, feature, attention, by_feature } = self;
        edges.combine_backward(by_combined, by_feature);
        if let Some(attention) = attention {
            scores.backward(edges, by_combined, feature, attention, by_feature);
        }
    }
}
