//! Rows of figures: what `eval --json` prints and `evaluation.json` holds.

use super::config::EvalConfig;
use crate::settings::word_of;
use covey_env::Evaluation;
use covey_env::radio::{RadioFigures, RadioSettings};
use serde::{Deserialize, Serialize};

/// One policy's figures: means over the held-out worlds and their standard errors. The metrics are
/// those of `docs/scenario.md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EvalRow {
    /// Whose figures.
    pub policy: String,
    /// Distribution of the PoIs, "clustered" or "uniform".
    pub scenario: String,
    /// UAVs in a world.
    pub uavs: usize,
    /// Held-out worlds.
    pub worlds: u32,
    /// Their seed.
    pub seed: u64,
    /// "sample" or "argmax"; "rule" for policies without logits.
    pub decide: String,
    /// Coverage index: mean over the steps of the share of PoIs that are covered.
    pub coverage: f64,
    /// Standard error of [`Self::coverage`].
    pub coverage_se: f64,
    /// Share of PoIs covered after the last step.
    pub coverage_last: f64,
    /// Standard error of [`Self::coverage_last`].
    pub coverage_last_se: f64,
    /// Energy index: 0.5 for hovering, 1 for full speed.
    pub energy: f64,
    /// Standard error of [`Self::energy`].
    pub energy_se: f64,
    /// PoIs that a UAV alone covers in its group.
    pub individual: f64,
    /// Standard error of [`Self::individual`].
    pub individual_se: f64,
    /// PoIs that the group of a UAV covers.
    pub group: f64,
    /// Standard error of [`Self::group`].
    pub group_se: f64,
    /// Episodic reward.
    pub reward: f64,
    /// Standard error of [`Self::reward`].
    pub reward_se: f64,
    /// Jain's index of the time that each PoI was covered.
    pub fairness: f64,
    /// Standard error of [`Self::fairness`].
    pub fairness_se: f64,
    /// What decided, when it was a processor in the loop.
    #[serde(flatten)]
    pub board: Option<PilFigures>,
    /// The radio and what it did, when the UAVs flew over one.
    #[serde(flatten)]
    pub radio: Option<RadioRow>,
}

/// Decisions that a processor in the loop made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PilFigures {
    /// The board, as `--actor` names it.
    pub actor: String,
    /// How many decisions.
    pub decisions: u64,
    /// In how many this computer gets another feature, other logits or another action.
    pub differences: u64,
}

/// What a radio did during an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadioRow {
    /// The radio, as `--radio` takes it.
    #[serde(rename = "link")]
    pub radio: String,
    /// Datagrams sent; one that is broadcast counts once a receiver.
    pub datagrams_sent: u64,
    /// Of them, those out of range.
    pub datagrams_out_of_range: u64,
    /// Of them, those lost on the way.
    pub datagrams_lost: u64,
    /// Datagrams that arrived, second copies among them.
    pub datagrams_delivered: u64,
    /// Messages that neighbour tables took.
    pub messages_taken: u64,
    /// Messages that they refused.
    pub messages_refused: u64,
    /// Datagrams that were no message.
    pub messages_malformed: u64,
    /// Share of the neighbours in range that their UAV knew of.
    pub neighbours_known: f64,
    /// Neighbours believed in range that were not, for each that was.
    pub neighbours_ghost: f64,
    /// Neighbours believed in range whose feature was at hand, for each that was in range.
    pub neighbours_with_feature: f64,
}

impl EvalRow {
    /// The row of an evaluation; `policy` and `decide` go into it.
    #[must_use]
    pub fn new(policy: &str, config: &EvalConfig, decide: &str, evaluation: &Evaluation) -> Self {
        let (mean, error) = (evaluation.mean(), evaluation.standard_error());
        Self {
            policy: policy.to_owned(),
            scenario: word_of(config.scenario.distribution).to_owned(),
            uavs: config.scenario.uavs,
            worlds: config.worlds,
            seed: config.seed,
            decide: decide.to_owned(),
            coverage: mean.coverage,
            coverage_se: error.coverage,
            coverage_last: mean.coverage_last,
            coverage_last_se: error.coverage_last,
            energy: mean.energy,
            energy_se: error.energy,
            individual: mean.individual,
            individual_se: error.individual,
            group: mean.group,
            group_se: error.group,
            reward: mean.reward,
            reward_se: error.reward,
            fairness: mean.fairness,
            fairness_se: error.fairness,
            board: None,
            radio: None,
        }
    }

    /// Every metric: name, mean and standard error.
    #[must_use]
    pub const fn metrics(&self) -> [(&'static str, f64, f64); 7] {
        [
            ("coverage", self.coverage, self.coverage_se),
            ("coverage_last", self.coverage_last, self.coverage_last_se),
            ("energy", self.energy, self.energy_se),
            ("individual", self.individual, self.individual_se),
            ("group", self.group, self.group_se),
            ("reward", self.reward, self.reward_se),
            ("fairness", self.fairness, self.fairness_se),
        ]
    }
}

impl RadioRow {
    /// The row of a radio with these figures.
    #[must_use]
    pub fn new(radio: &RadioSettings, figures: &RadioFigures) -> Self {
        let RadioFigures { counts, taken, refused, malformed, neighbours, known, ghosts, features } = *figures;
        let share = |n: u64| n as f64 / neighbours.max(1) as f64;
        Self {
            radio: radio.to_string(),
            datagrams_sent: counts.sent,
            datagrams_out_of_range: counts.out_of_range,
            datagrams_lost: counts.lost,
            datagrams_delivered: counts.delivered,
            messages_taken: taken,
            messages_refused: refused,
            messages_malformed: malformed,
            neighbours_known: share(known),
            neighbours_ghost: share(ghosts),
            neighbours_with_feature: share(features),
        }
    }
}

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
