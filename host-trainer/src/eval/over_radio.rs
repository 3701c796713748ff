//! The actor over a radio that loses and delays messages: the rows of `eval --radio`.

use super::config::EvalConfig;
use super::row::{EvalRow, RadioRow};
use super::watch::Watch;
use crate::settings::word_of;
use covey_env::radio::{RadioPolicy, RadioSettings, RadioWorldError, evaluate_over_radio};
use covey_env::{Evaluation, World, policy_seed};
use firmware_core::actor::{ActorInput, QuantisedActor};

/// Evaluates the int8 actor with every message going over the radio; `name` goes into the row.
/// Also returns the metrics of each world, so that two radios can be compared world by world. Tells `watch` how far
/// it is.
///
/// # Errors
/// When the scenario or the radio cannot be, or the radio serves fewer UAVs.
pub fn evaluate_with_radio<O: ActorInput>(
    actor: &QuantisedActor<'_, O>,
    name: &str,
    config: &EvalConfig,
    radio: &RadioSettings,
    watch: Watch<'_>,
) -> Result<(EvalRow, Evaluation), RadioWorldError> {
    let policy = RadioPolicy::new(*actor, 0, config.mode, radio, config.scenario.uavs)?;
    let seeds = |index| policy_seed(config.seed, index);
    let worlds = u64::from(config.worlds);
    let on_state = |world: &World| {
        if world.steps_done() > 0 {
            watch(world.scenario().uavs as u64);
        }
    };
    let (evaluation, figures) = evaluate_over_radio(&config.scenario, config.seed, worlds, &policy, seeds, on_state)?;
    let mut row = EvalRow::new(name, config, word_of(config.mode), &evaluation);
    row.radio = Some(RadioRow::new(radio, &figures));
    Ok((row, evaluation))
}
