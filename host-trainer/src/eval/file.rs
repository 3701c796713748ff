//! `evaluation.json` of a run folder.

use super::row::EvalRow;
use serde::{Deserialize, Serialize};

/// What `evaluation.json` holds, see `docs/run-folder.md`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EvaluationFile {
    /// Policies on the same held-out worlds, the int8 actor first.
    pub rows: Vec<EvalRow>,
    /// Share of decisions in which int8 and float have the same greatest logit, 0 to 1.
    pub argmax_agreement: f64,
    /// How many decisions were compared.
    pub decisions_compared: u64,
}
