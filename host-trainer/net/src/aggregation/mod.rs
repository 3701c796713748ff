//! Combining the features of a neighbourhood, before the graph layer's weights.

mod aggregate;
mod attention;
mod edges;
mod gatv2;
mod gcn;
mod sage;
mod vectors;

pub(crate) use aggregate::{Aggregate, Weighing};
pub(crate) use attention::{Attention, AttentionGradient};
pub(crate) use gatv2::{Score, ScoreGradient, ScoredAggregate};
