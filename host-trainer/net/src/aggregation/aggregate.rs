//! The weighted sum over a neighbourhood, forward and backward.

use super::attention::{Attention, AttentionGradient, AttentionScores};
use super::edges::Edges;
use super::gcn::weigh_by_degree;
use crate::input::Inputs;
use crate::kernel::{Vectorised, vectorised};
use crate::matrix::Rows;

/// The edges of a micro-batch with their weights, kept from the forward to the backward pass.
#[derive(Clone, Debug, Default)]
pub struct Aggregate {
    edges: Edges,
    scores: AttentionScores,
}

impl Aggregate {
    /// `combined[i] = Σ_j weight_ij · feature[j]` over each UAV itself and its neighbours: with
    /// the weights of a GAT if there is attention, else with those of a GCN.
    pub fn forward(&mut self, inputs: &Inputs, attention: Option<&Attention>, feature: &Rows, combined: &mut Rows) {
        combined.resize(feature.rows());
        vectorised(Forward { aggregate: self, inputs, attention, feature, combined });
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
    attention: Option<&'a Attention>,
    feature: &'a Rows,
    combined: &'a mut Rows,
}

impl Vectorised for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Aggregate { edges, scores } = self.aggregate;
        edges.list(self.inputs);
        match self.attention {
            None => weigh_by_degree(edges, self.inputs.neighbours()),
            Some(attention) => scores.weigh(edges, attention, self.feature),
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
