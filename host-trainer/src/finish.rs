//! The end of a run: quantise, measure, write the actor file.

use crate::any_actor::AnyActor;
use crate::float_actor::FloatActor;
use crate::measure::{EvalRow, Subject, Trial, agreement};
use crate::quantise::{QuantiseError, quantise, with_provenance};
use crate::settings::{Settings, distribution_name};
use crate::train::State;
use crate::with_actor;
use firmware_core::actor::{Mode, Provenance};
use serde::{Deserialize, Serialize};

/// Worlds on which int8 and float decisions are compared: 50 of 20 UAVs and 100 steps
/// are 100,000 decisions.
const AGREEMENT_WORLDS: u32 = 50;

/// A quantised policy with its figures.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The actor file.
    pub file: Vec<u8>,
    /// The int8 actor on held-out worlds.
    pub int8: EvalRow,
    /// The float policy on the same.
    pub float: EvalRow,
    /// Share of decisions in which both have the same greatest logit.
    pub agreement: f64,
    /// Decisions compared.
    pub compared: u64,
}

/// What `evaluation.json` holds.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EvaluationFile {
    /// Policies on the same held-out worlds.
    pub rows: Vec<EvalRow>,
    /// Share of decisions in which int8 and float have the same greatest logit.
    pub argmax_agreement: f64,
    /// Decisions compared.
    pub decisions_compared: u64,
}

/// The held-out worlds of a run.
#[must_use]
pub fn trial(s: &Settings) -> Trial {
    Trial { scenario: s.world(), seed: s.eval_seed, worlds: s.eval_worlds, mode: Mode::Sample }
}

/// Quantises the policy of a state and measures it beside the float policy.
///
/// # Errors
/// When the policy cannot be quantised.
pub fn actor_file(s: &Settings, state: &State) -> Result<Finished, QuantiseError> {
    let float = FloatActor::new(s, state.average.clone());
    let provenance = Provenance {
        trainer: concat!("covey ", env!("CARGO_PKG_VERSION")),
        scenario: distribution_name(s.poi_distribution),
        uavs: s.uavs,
        seed: s.seed,
        episodes: state.rounds * s.num_envs,
        worlds: 0,
        float_coverage: 0,
        int8_coverage: 0,
    };
    // Calibration worlds are neither training nor held-out ones.
    let file = quantise(&float, &s.world(), s.seed ^ 0x6361_6c69, s.calibration_worlds, provenance)?;
    let trial = trial(s);
    let actor = AnyActor::load(&file)?;
    let int8 = Subject::of(&actor).measure(&format!("{} int8", s.graph.0.name()), &trial)?;
    let by_float = Subject::Float(&float).measure(&format!("{} float", s.graph.0.name()), &trial)?;
    let compared = Trial { worlds: trial.worlds.min(AGREEMENT_WORLDS), ..trial.clone() };
    let (agreeing, decisions) = with_actor!(actor, actor => agreement(actor, &float, &compared))?;
    let share = |c: f64| (c * 10_000.0).round() as u16;
    let provenance = Provenance {
        worlds: trial.worlds,
        float_coverage: share(by_float.coverage),
        int8_coverage: share(int8.coverage),
        ..provenance
    };
    Ok(Finished {
        file: with_provenance(&file, provenance)?,
        int8,
        float: by_float,
        agreement: agreeing as f64 / decisions as f64,
        compared: decisions,
    })
}
