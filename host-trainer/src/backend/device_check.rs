//! A device's outputs and gradients compared with those that the CPU computes.

use super::workspace::Workspace;
use crate::optim::Learner;
use covey_net::{ActorCritic, Engine, EngineError, GraphBatch, Inputs, Outputs, ParameterLayout, Rows};

/// Most that a device's numbers may be off, of the greatest: GPUs may multiply with fewer
/// digits, a wrong kernel is off by all.
const TOLERANCE: f32 = 0.02;

/// Compares logits, values and gradients of a batch. The device must have the learner's
/// parameters; the batch is its rollout afterwards.
///
/// # Errors
/// When the device fails or its numbers are off.
pub fn check(
    engine: &mut dyn Engine,
    batch: GraphBatch<'_>,
    layouts: &ActorCritic<ParameterLayout>,
    learner: &Learner,
) -> Result<(), EngineError> {
    let (inputs, _) = layouts.actor.shape("encoder1");
    let mut cpu = Workspace::new(layouts, Inputs::new(inputs));
    cpu.set_inputs(batch.uavs, batch.observations.into(), batch.neighbours);
    cpu.forward(learner);
    let expected = Outputs { logits: cpu.actor.logits().clone(), values: cpu.critic.values().clone() };
    set_test_gradient(cpu.actor.logits_mut());
    set_test_gradient(cpu.critic.values_mut());
    cpu.backward(learner);
    let mut expected_gradients = layouts.as_ref().map(|layout| vec![0.0; layout.len()]);
    cpu.store_gradients(learner, &mut expected_gradients);

    let (mut outputs, mut gradients) = (Outputs::default(), ActorCritic::default());
    engine.forward(&[batch], &mut outputs)?;
    compare(engine, "logits", outputs.logits.values(), expected.logits.values())?;
    compare(engine, "values", outputs.values.values(), expected.values.values())?;
    engine.load_rollout(&[batch]);
    let all: Vec<u32> = (0..batch.world_steps() as u32).collect();
    let mut backward = |out: &mut Outputs| {
        set_test_gradient(&mut out.logits);
        set_test_gradient(&mut out.values);
    };
    engine.gradient(&all, &mut outputs, &mut backward, &mut gradients)?;
    compare(engine, "the actor's gradient", &gradients.actor, &expected_gradients.actor)?;
    compare(engine, "the critic's gradient", &gradients.critic, &expected_gradients.critic)
}

fn compare(engine: &dyn Engine, what: &'static str, got: &[f32], expected: &[f32]) -> Result<(), EngineError> {
    let greatest = expected.iter().fold(f32::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let differences = got.iter().zip(expected).map(|(g, e)| (g - e).abs());
    // `max` alone would drop what is not a number.
    let difference = differences.map(|d| if d.is_nan() { f32::INFINITY } else { d }).fold(0.0, f32::max);
    let error = if got.len() == expected.len() { difference / greatest } else { f32::INFINITY };
    if error <= TOLERANCE { Ok(()) } else { Err(EngineError::Wrong { device: engine.name(), what, error }) }
}

/// Overwrites rows by a gradient with all kinds of numbers in it, whole ones from −5 to 5.
fn set_test_gradient(rows: &mut Rows) {
    let (stride, width) = (rows.stride(), rows.width());
    for (r, row) in rows.values_mut().chunks_exact_mut(stride).enumerate() {
        row[..width].iter_mut().enumerate().for_each(|(c, v)| *v = ((7 * r + 5 * c) % 11) as f32 - 5.0);
        row[width..].fill(0.0);
    }
}
