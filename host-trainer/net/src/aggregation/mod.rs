//! Combining the features of a neighbourhood, before the graph layer's weights.

mod aggregate;
mod attention;
mod edges;
mod gcn;
mod vectors;

pub(crate) use aggregate::Aggregate;
pub(crate) use attention::{Attention, AttentionGradient};
