//! Quantisation: int8 weights with one multiplier a row, from the float policy.

use super::calibrate::{Ranges, Situation, calibrate};
use super::error::QuantiseError;
use super::graph::push_graph;
use super::layers::{Blobs, FloatLayer, Order, Output, scales};
use crate::eval::{AnyActor, Watch};
use crate::float_actor::{FloatActor, argmax as float_argmax};
use covey_env::{BatchedObservation, ObservationForm, Scenario, neighbour_features};
use firmware_core::actor::file::{Body, HEADER, TRAILER};
use firmware_core::actor::{Feature, LoadError, Provenance, QuantisedActor, SELF_TESTS, argmax, write_self_test};
use firmware_core::observation::Observation;
use firmware_core::observation::cells::Cells;

/// How far a channel's scale follows its own range rather than the layer's: candidates
/// among which calibration picks the one that chooses most like the float policy.
const OWN_RANGE: [f64; 4] = [0.0, 0.35, 0.7, 1.0];

/// Quantises a policy into an actor file, after calibrating it on worlds 0 to `worlds` − 1 of `seed`,
/// which should be neither training nor held-out ones. Tells `watch` how far it is with them.
///
/// # Errors
/// See [`QuantiseError`].
pub fn quantise(
    actor: &FloatActor,
    scenario: &Scenario,
    seed: u64,
    worlds: u32,
    provenance: Provenance<'_>,
    watch: Watch<'_>,
) -> Result<Vec<u8>, QuantiseError> {
    match actor.observation {
        ObservationForm::Compact => quantise_as::<Observation>(actor, scenario, seed, worlds, provenance, watch),
        ObservationForm::Cells => quantise_as::<Cells>(actor, scenario, seed, worlds, provenance, watch),
    }
}

fn quantise_as<O: BatchedObservation>(
    actor: &FloatActor,
    scenario: &Scenario,
    seed: u64,
    worlds: u32,
    provenance: Provenance<'_>,
    watch: Watch<'_>,
) -> Result<Vec<u8>, QuantiseError> {
    let (ranges, situations) = calibrate(actor, scenario, seed, worlds, watch)?;
    let mut best: Option<(usize, Vec<u8>)> = None;
    for own in OWN_RANGE {
        let file = compose::<O>(actor, &ranges, own, &situations, provenance)?;
        let agreeing = situation_agreement(&QuantisedActor::<O>::load(&file)?, &situations).0;
        if best.as_ref().is_none_or(|(most, _)| agreeing > *most) {
            best = Some((agreeing, file));
        }
    }
    let (_, file) = best.unwrap_or_default();
    QuantisedActor::<O>::load(&file)?.self_test()?;
    Ok(file)
}

/// The same actor file with another provenance: for the figures, which are known only once the actor
/// has flown.
///
/// # Errors
/// When `file` is no sound actor file.
pub(super) fn with_provenance(file: &[u8], provenance: Provenance<'_>) -> Result<Vec<u8>, QuantiseError> {
    let body = file.get(HEADER..file.len().saturating_sub(TRAILER)).unwrap_or(&[]);
    AnyActor::load(file)?;
    let body: Body<'_> = postcard::from_bytes(body).map_err(|_| LoadError::Malformed)?;
    store(&Body { provenance, ..body })
}

fn store(body: &Body<'_>) -> Result<Vec<u8>, QuantiseError> {
    let mut out = vec![0; body.weights.len() + body.tables.len() + body.self_tests.len() + 4096];
    let n = body.store(&mut out)?;
    out.truncate(n);
    Ok(out)
}

fn compose<O: BatchedObservation>(
    actor: &FloatActor,
    ranges: &Ranges,
    own: f64,
    situations: &[Situation],
    provenance: Provenance<'_>,
) -> Result<Vec<u8>, QuantiseError> {
    let p = |name| actor.layout.block(&actor.values, name);
    let layer = |name, weights, biases| FloatLayer::from_columns(name, p(weights), p(biases));
    let mut blobs = Blobs::default();
    let input = vec![1.0 / 127.0; O::LEN];
    let order = match actor.observation {
        ObservationForm::Compact => Order::RowPairs,
        ObservationForm::Cells => Order::Columns,
    };
    let mut hidden = scales(&ranges.hidden, own);
    let first = layer("first encoder", "encoder1", "encoder1 bias");
    blobs.push_in(order, &first, &input, Output::Int8(&mut hidden))?;
    let mut feature = scales(&ranges.feature, own);
    blobs.push(&layer("second encoder", "encoder2", "encoder2 bias"), &hidden, Output::Int8(&mut feature))?;
    let mut joined = feature.clone();
    let mut head_layer = layer("head", "head own", "head bias");
    let graph = push_graph(&mut blobs, actor, ranges, own, &feature)?;
    let aggregate_multiplier = graph.as_ref().map_or(0, |g| g.multiplier);
    if let Some(graph) = graph {
        joined.extend(graph.scales);
        head_layer = head_layer.beside(p("head aggregate"));
    }
    let mut head = scales(&ranges.head, own);
    blobs.push(&head_layer, &joined, Output::Int8(&mut head))?;
    blobs.push(&layer("output", "output", "output bias"), &head, Output::Wide)?;
    let body = Body {
        align: &[],
        weights: &blobs.weights,
        tables: &blobs.tables,
        observation: O::ID,
        aggregation: actor.aggregation,
        dimensions: actor.dimensions,
        tie_period: actor.tie_period,
        aggregate_multiplier,
        provenance,
        self_tests: &[],
        content_hash: 0,
    };
    with_self_tests::<O>(&body, situations)
}

/// The logits of UAV `i` of a situation whose UAVs have these features.
fn int8_logits<O: BatchedObservation>(
    actor: &QuantisedActor<'_, O>,
    features: &[Feature],
    s: &Situation,
    i: usize,
) -> [i16; 17] {
    let width = usize::from(actor.dimensions().feature);
    actor.logits(&features[i], s.neighbourhoods[i].count + 1, neighbour_features(features, width, &s.neighbourhoods, i))
}

/// In how many decisions of these situations the int8 actor's greatest logit is the float policy's,
/// and how many decisions there are.
#[must_use]
pub fn situation_agreement<O: BatchedObservation>(
    actor: &QuantisedActor<'_, O>,
    situations: &[Situation],
) -> (usize, usize) {
    let (mut agreeing, mut all) = (0, 0);
    for s in situations {
        let features: Vec<Feature> = O::among(&s.observations).iter().map(|o| actor.encode(o)).collect();
        for (i, row) in s.logits.chunks_exact(17).enumerate() {
            let own = argmax(&int8_logits(actor, &features, s, i));
            agreeing += usize::from(own == float_argmax(row));
            all += 1;
        }
    }
    (agreeing, all)
}

/// The file with self-tests of situations spread over the calibration.
fn with_self_tests<O: BatchedObservation>(body: &Body<'_>, situations: &[Situation]) -> Result<Vec<u8>, QuantiseError> {
    let width = usize::from(body.dimensions.feature);
    let vectors = |actor: Option<&QuantisedActor<'_, O>>| {
        let mut bytes = Vec::new();
        for k in 0..SELF_TESTS {
            let s = &situations[(2 * k + 1) * situations.len() / (2 * SELF_TESTS)];
            // The UAV with most neighbours in every other vector.
            let most = |&i: &usize| s.neighbourhoods[i].count;
            let i = if k % 2 == 0 {
                k % s.neighbourhoods.len()
            } else {
                (0..s.neighbourhoods.len()).max_by_key(most).unwrap_or(0)
            };
            let blank = Feature { own: [0; 64], values: [0; 64], attention_destination: 0, attention_source: 0 };
            let features: Vec<Feature> =
                O::among(&s.observations).iter().map(|o| actor.map_or(blank, |a| a.encode(o))).collect();
            let logits = actor.map_or([0; 17], |a| int8_logits(a, &features, s, i));
            let neighbours: Vec<_> = neighbour_features(&features, width, &s.neighbourhoods, i).collect();
            let mut buffer = [0; 2048];
            let n = write_self_test(
                &mut buffer,
                &O::among(&s.observations)[i],
                s.neighbourhoods[i].count + 1,
                &neighbours,
                &logits,
            );
            bytes.extend(&buffer[..n.unwrap_or(0)]);
        }
        bytes
    };
    // Logits do not depend on the vectors: compute them with blank ones first.
    let blank = vectors(None);
    let draft = store(&Body { self_tests: &blank, ..*body })?;
    let tests = vectors(Some(&QuantisedActor::load(&draft)?));
    store(&Body { self_tests: &tests, ..*body })
}
