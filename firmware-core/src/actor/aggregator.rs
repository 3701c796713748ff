//! The layers between encoder and head: from a UAV's `h` to what it broadcasts, and from
//! features that were heard to `y`.

use super::aggregation::Aggregation;
use super::feature::{Feature, MAX_FEATURE, NeighbourFeature};
use super::graph::{self, RECEIVER_MAX};
use super::layer::{Activations, Layer, LayerError};
use crate::kernel::requantise;

/// The layers of each aggregation.
#[derive(Clone, Copy, Debug)]
pub(super) enum Aggregator<'a> {
    /// Plain PPO.
    None,
    /// Combines `h`, then the graph layer.
    Gcn { graph: Layer<'a> },
    /// The two halves of the score (rows: receiver, sender), and the graph layer.
    Gat { attention: Layer<'a>, graph: Layer<'a> },
    /// `W_l`, `W_r` and `a`.
    GatV2 { receiver: Layer<'a>, sender: Layer<'a>, attention: Layer<'a> },
    /// As [`Self::Gcn`].
    Sage { graph: Layer<'a> },
}

impl<'a> Aggregator<'a> {
    /// Has `layer` take the layers of these rows and columns, in file order.
    pub(super) fn take(
        aggregation: Aggregation,
        feature: usize,
        mut layer: impl FnMut(usize, usize) -> Result<Layer<'a>, LayerError>,
    ) -> Result<Self, LayerError> {
        Ok(match aggregation {
            Aggregation::None => Self::None,
            Aggregation::Gcn => Self::Gcn { graph: layer(feature, feature)? },
            Aggregation::Gat => Self::Gat { attention: layer(2, feature)?, graph: layer(feature, feature)? },
            Aggregation::GatV2 => Self::GatV2 {
                receiver: layer(feature, feature)?,
                sender: layer(feature, feature)?,
                attention: layer(1, feature)?,
            },
            Aggregation::Sage => Self::Sage { graph: layer(feature, feature)? },
        })
    }

    /// Which aggregation it is.
    pub(super) const fn kind(&self) -> Aggregation {
        match self {
            Self::None => Aggregation::None,
            Self::Gcn { .. } => Aggregation::Gcn,
            Self::Gat { .. } => Aggregation::Gat,
            Self::GatV2 { .. } => Aggregation::GatV2,
            Self::Sage { .. } => Aggregation::Sage,
        }
    }

    /// The feature of a UAV with this `h`.
    pub(super) fn feature(&self, h: &Activations<MAX_FEATURE>) -> Feature {
        let own = int8(h);
        let mut feature = Feature { own, values: own, attention_destination: 0, attention_source: 0 };
        match self {
            Self::None | Self::Gcn { .. } | Self::Sage { .. } => {}
            Self::Gat { attention, .. } => {
                let mut halves = [0i16; 2];
                attention.apply_wide(&h.0, &mut halves);
                [feature.attention_destination, feature.attention_source] = halves;
            }
            Self::GatV2 { sender, .. } => {
                let mut sent = Activations::zero();
                sender.apply_wide(&h.0, &mut sent.0);
                feature.values = int8(&sent);
            }
        }
        feature
    }

    /// Combines the features, with `multiplier` of the sums, and writes `y`: int8 from 0 on, or
    /// nothing without aggregation.
    pub(super) fn apply(
        &self,
        own: &Feature,
        degree: u8,
        neighbours: &[NeighbourFeature<'_>],
        multiplier: i32,
        y: &mut [i16],
    ) {
        let (sums, graph) = match self {
            Self::None => return,
            Self::Gcn { graph } => (graph::gcn(own, degree, neighbours), graph),
            Self::Gat { graph, .. } => (graph::gat(own, neighbours), graph),
            Self::Sage { graph } => (graph::mean(neighbours), graph),
            Self::GatV2 { receiver, attention, .. } => {
                let sums = graph::gatv2(own, &received(receiver, own), attention.first_row(), neighbours);
                for (y, &sum) in y.iter_mut().zip(&sums) {
                    *y = requantise(sum, multiplier).clamp(0, 127) as i16;
                }
                return;
            }
        };
        let mut combined = Activations::<MAX_FEATURE>::zero();
        for (x, &sum) in combined.0.iter_mut().zip(&sums) {
            *x = requantise(sum, multiplier).clamp(-127, 127) as i16;
        }
        graph.apply(&combined.0, y);
    }
}

/// `W_l h` of the receiver, within ±[`RECEIVER_MAX`].
fn received(receiver: &Layer<'_>, own: &Feature) -> [i16; MAX_FEATURE] {
    let mut h = Activations::<MAX_FEATURE>::zero();
    for (h, &own) in h.0.iter_mut().zip(&own.own) {
        *h = i16::from(own);
    }
    let mut out = [0; MAX_FEATURE];
    receiver.apply_wide(&h.0, &mut out);
    out.map(|v| v.clamp(-RECEIVER_MAX, RECEIVER_MAX))
}

/// Within ±127.
fn int8(wide: &Activations<MAX_FEATURE>) -> [i8; MAX_FEATURE] {
    wide.0.map(|v| v.clamp(-127, 127) as i8)
}
