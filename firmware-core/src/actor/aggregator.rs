//! The layers between encoder and head: from a UAV's `h` to what it broadcasts, and from
//! features that were heard to `y`.

use super::aggregation::Aggregation;
use super::feature::{Feature, MAX_FEATURE, NeighbourFeature};
use super::graph::{self, RECEIVER_MAX};
use super::layer::{Activations, Layer, LayerError, Row};
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
    #[inline(never)]
    pub(super) fn feature(&self, h: &Activations<MAX_FEATURE>) -> Feature {
        let mut feature =
            Feature { own: [0; MAX_FEATURE], values: [0; MAX_FEATURE], attention_destination: 0, attention_source: 0 };
        int8(h, &mut feature.own);
        match self {
            Self::None | Self::Gcn { .. } | Self::Sage { .. } => feature.values = feature.own,
            Self::Gat { attention, .. } => {
                feature.values = feature.own;
                let mut halves = [0i16; 2];
                attention.apply_wide(&h.0, &mut halves);
                [feature.attention_destination, feature.attention_source] = halves;
            }
            Self::GatV2 { sender, .. } => {
                let mut sent = Activations::zero();
                sender.apply_wide(&h.0, &mut sent.0);
                int8(&sent, &mut feature.values);
            }
        }
        feature
    }

    /// Combines the features, with `multiplier` of the sums, and writes `y`, zeros before: int8
    /// from 0 on, or nothing without aggregation. Its parts are functions of their own: none keeps
    /// its arrays on a board's stack while another runs.
    pub(super) fn apply(
        &self,
        own: &Feature,
        degree: u8,
        neighbours: &[NeighbourFeature<'_>],
        multiplier: i32,
        y: &mut [i16],
    ) {
        match self {
            Self::None => {}
            Self::Gcn { graph } | Self::Gat { graph, .. } | Self::Sage { graph } => {
                let mut combined = Activations::zero();
                self.combine(own, degree, neighbours, multiplier, &mut combined);
                graph.apply(&combined.0, y);
            }
            Self::GatV2 { receiver, attention, .. } => {
                receive(receiver, own, y);
                attend(attention.first_row(), own, neighbours, multiplier, y);
            }
        }
    }

    /// What the graph layer takes, int8.
    #[inline(never)]
    fn combine(
        &self,
        own: &Feature,
        degree: u8,
        neighbours: &[NeighbourFeature<'_>],
        multiplier: i32,
        combined: &mut Activations<MAX_FEATURE>,
    ) {
        let mut sums = [0; MAX_FEATURE];
        match self {
            Self::Gat { .. } => graph::gat(&mut sums, own, neighbours),
            Self::Sage { .. } => graph::mean(&mut sums, neighbours),
            _ => graph::gcn(&mut sums, own, degree, neighbours),
        }
        for (x, &sum) in combined.0.iter_mut().zip(&sums) {
            *x = requantise(sum, multiplier).clamp(-127, 127) as i16;
        }
    }
}

/// GATv2: writes `W_l h` of the receiver, within ±[`RECEIVER_MAX`].
#[inline(never)]
fn receive(receiver: &Layer<'_>, own: &Feature, out: &mut [i16]) {
    let mut h = Activations::<MAX_FEATURE>::zero();
    for (h, &own) in h.0.iter_mut().zip(&own.own) {
        *h = i16::from(own);
    }
    receiver.apply_wide(&h.0, out);
    for v in out {
        *v = (*v).clamp(-RECEIVER_MAX, RECEIVER_MAX);
    }
}

/// GATv2: takes the receiver's `W_l h` from `y` and writes `y` in its place.
#[inline(never)]
fn attend(attention: Row<'_>, own: &Feature, neighbours: &[NeighbourFeature<'_>], multiplier: i32, y: &mut [i16]) {
    let mut sums = [0; MAX_FEATURE];
    graph::gatv2(&mut sums, own, y, attention, neighbours);
    for (y, &sum) in y.iter_mut().zip(&sums) {
        *y = requantise(sum, multiplier).clamp(0, 127) as i16;
    }
}

/// Within ±127.
fn int8(wide: &Activations<MAX_FEATURE>, out: &mut [i8; MAX_FEATURE]) {
    for (out, &v) in out.iter_mut().zip(&wide.0) {
        *out = v.clamp(-127, 127) as i8;
    }
}
