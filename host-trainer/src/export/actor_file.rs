//! The actor file of a run: quantised, measured beside the float policy, with its provenance.

use super::error::QuantiseError;
use super::quantise::{quantise, with_provenance};
use crate::eval::{
    Agreement, AnyActor, EvalConfig, EvalPolicy, EvalRow, UNWATCHED, Watch, argmax_agreement, with_actor,
};
use crate::float_actor::FloatActor;
use crate::settings::{Settings, word_of};
use crate::train::State;
use firmware_core::actor::Provenance;

/// Worlds on which int8 and float decisions are compared: 50 of 20 UAVs and 100 steps
/// are 100,000 decisions.
const AGREEMENT_WORLDS: u32 = 50;

/// An actor file with its figures.
#[derive(Clone, Debug)]
pub struct ExportedActor {
    /// The actor file's bytes.
    pub file: Vec<u8>,
    /// The int8 actor on the held-out worlds.
    pub int8: EvalRow,
    /// The float policy on the same worlds.
    pub float: EvalRow,
    /// How often both have the same greatest logit.
    pub agreement: Agreement,
}

/// Quantises the averaged policy of a run's state and measures it beside the float policy on the
/// run's held-out worlds; both coverages go into the file.
///
/// # Errors
/// When the policy cannot be quantised.
pub fn export_actor(s: &Settings, state: &State) -> Result<ExportedActor, QuantiseError> {
    export_actor_watched(s, state, UNWATCHED)
}

/// Agent-steps that [`export_actor`] flies for these settings.
#[must_use]
pub fn export_agent_steps(s: &Settings) -> u64 {
    let held_out = EvalConfig::held_out(s);
    let calibration = EvalConfig { worlds: s.calibration_worlds, ..held_out.clone() };
    calibration.agent_steps() + 2 * held_out.agent_steps() + compared(held_out).agent_steps()
}

/// The worlds on which int8 and float decisions are compared.
fn compared(held_out: EvalConfig) -> EvalConfig {
    EvalConfig { worlds: held_out.worlds.min(AGREEMENT_WORLDS), ..held_out }
}

/// [`export_actor`] that tells `watch` how far it is, in agent-steps.
///
/// # Errors
/// When the policy cannot be quantised.
pub fn export_actor_watched(s: &Settings, state: &State, watch: Watch<'_>) -> Result<ExportedActor, QuantiseError> {
    let float = FloatActor::new(s, state.average.clone());
    let provenance = Provenance {
        trainer: concat!("covey ", env!("CARGO_PKG_VERSION")),
        scenario: word_of(s.poi_distribution),
        uavs: s.uavs,
        seed: s.seed,
        episodes: state.rounds * s.num_envs,
        worlds: 0,
        float_coverage: 0,
        int8_coverage: 0,
    };
    // A seed of its own: calibration worlds are neither training nor held-out ones.
    let calibration_seed = s.seed ^ 0x6361_6c69;
    let file = quantise(&float, &s.world(), calibration_seed, s.calibration_worlds, provenance, watch)?;
    let held_out = EvalConfig::held_out(s);
    let actor = AnyActor::load(&file)?;
    let name = word_of(s.graph);
    let int8 = EvalPolicy::of(&actor).evaluate_watched(&format!("{name} int8"), &held_out, watch)?;
    let by_float = EvalPolicy::Float(&float).evaluate_watched(&format!("{name} float"), &held_out, watch)?;
    let agreement = with_actor!(actor, actor => argmax_agreement(actor, &float, &compared(held_out.clone()), watch))?;
    let share = |c: f64| (c * 10_000.0).round() as u16;
    let provenance = Provenance {
        worlds: held_out.worlds,
        float_coverage: share(by_float.coverage),
        int8_coverage: share(int8.coverage),
        ..provenance
    };
    Ok(ExportedActor { file: with_provenance(&file, provenance)?, int8, float: by_float, agreement })
}
