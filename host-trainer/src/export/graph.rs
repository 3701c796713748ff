//! The layers between encoder and head in int8.

use super::calibrate::Ranges;
use super::error::QuantiseError;
use super::layers::{Blobs, FloatLayer, Output, scales};
use crate::float_actor::FloatActor;
use firmware_core::actor::{Aggregation, RECEIVER_MAX};

/// What comes out of them.
pub struct GraphOutput {
    /// Multiplier of the aggregated features.
    pub multiplier: i32,
    /// Scales of what the head takes beside the feature.
    pub scales: Vec<f64>,
}

/// Quantises the layers that an aggregation has; the features have the scales `feature`. None
/// without aggregation.
///
/// # Errors
/// As [`Blobs::push`].
pub fn push_graph(
    blobs: &mut Blobs,
    actor: &FloatActor,
    ranges: &Ranges,
    own: f64,
    feature: &[f64],
) -> Result<Option<GraphOutput>, QuantiseError> {
    match actor.aggregation {
        Aggregation::None => return Ok(None),
        Aggregation::Gcn | Aggregation::Sage => {}
        Aggregation::Gat => blobs.push(&halves(actor), feature, Output::Wide)?,
        Aggregation::GatV2 => return push_gatv2(blobs, actor, ranges, own, feature).map(Some),
    }
    let grown = grown(&ranges.combined, feature);
    let combined: Vec<f64> = feature.iter().map(|s| s * grown).collect();
    let mut scales = scales(&ranges.graph, own);
    blobs.push(&layer(actor, "graph", "graph", "graph bias"), &combined, Output::Int8(&mut scales))?;
    Ok(Some(GraphOutput { multiplier: multiplier(grown), scales }))
}

/// What the receiver scores with and what is broadcast have the same scales, as they are added up.
fn push_gatv2(
    blobs: &mut Blobs,
    actor: &FloatActor,
    ranges: &Ranges,
    own: f64,
    feature: &[f64],
) -> Result<GraphOutput, QuantiseError> {
    let room = f32::from(RECEIVER_MAX) / 127.0;
    let both: Vec<f32> = ranges.sender.iter().zip(&ranges.receiver).map(|(r, l)| r.max(l / room)).collect();
    let mut sent = scales(&both, own);
    let ends = [layer(actor, "receiver", "receiver", "receiver bias"), layer(actor, "sender", "sender", "sender bias")];
    ends.iter().for_each(|end| end.widen(feature, &mut sent));
    for end in &ends {
        blobs.push(end, feature, Output::Signed(&sent))?;
    }
    // Of five times the leaky ReLU.
    let fifths: Vec<f64> = sent.iter().map(|s| s / 5.0).collect();
    let a = actor.layout.block(&actor.values, "attention").iter().map(|&a| f64::from(a)).collect();
    blobs.push(&FloatLayer { name: "attention", weights: vec![a], biases: vec![0.0] }, &fifths, Output::Wide)?;
    let grown = grown(&ranges.graph, &sent);
    Ok(GraphOutput { multiplier: multiplier(grown), scales: sent.iter().map(|s| s * grown).collect() })
}

/// One factor for all channels: combined features keep the features' scales, times what the
/// fullest channel needs.
fn grown(ranges: &[f32], scales: &[f64]) -> f64 {
    ranges.iter().zip(scales).fold(1e-3, |m: f64, (&r, s)| m.max(f64::from(r) / (127.0 * s)))
}

/// Takes the factor back from sums in Q15.
fn multiplier(grown: f64) -> i32 {
    ((1u64 << 17) as f64 / grown).round().min(f64::from(i32::MAX)) as i32
}

fn layer(actor: &FloatActor, name: &'static str, weights: &str, biases: &str) -> FloatLayer {
    let p = |name| actor.layout.block(&actor.values, name);
    FloatLayer::from_columns(name, p(weights), p(biases))
}

/// The two halves of the score, `W a₁` and `W a₂`, as a layer of two rows.
fn halves(actor: &FloatActor) -> FloatLayer {
    let p = |name| actor.layout.block(&actor.values, name);
    let (w, width) = (p("graph"), usize::from(actor.dimensions.feature));
    let half = |a: &[f32]| {
        w.chunks_exact(width).map(|row| row.iter().zip(a).map(|(w, a)| f64::from(*w) * f64::from(*a)).sum()).collect()
    };
    FloatLayer {
        name: "attention",
        weights: vec![half(p("attention receiver")), half(p("attention sender"))],
        biases: vec![0.0; 2],
    }
}
