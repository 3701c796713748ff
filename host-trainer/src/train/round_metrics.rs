//! Metrics of a round, and how they are shown.

use covey_report::metrics::nan_as_null;
use serde::{Deserialize, Serialize};

/// What a round gave: one row of `metrics.jsonl`. Episode metrics are means over the round's
/// episodes in worlds of the configured scenario; a value that cannot be had is NaN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoundMetrics {
    /// Episodes played so far.
    pub episodes: u64,
    /// Agent-steps so far.
    pub agent_steps: u64,
    /// Coverage index, mean over steps and the round's episodes.
    #[serde(with = "nan_as_null")]
    pub coverage: f64,
    /// Coverage after the last step.
    #[serde(with = "nan_as_null")]
    pub coverage_last: f64,
    /// Energy index.
    #[serde(with = "nan_as_null")]
    pub energy: f64,
    /// PoIs a UAV alone covers in its group.
    #[serde(with = "nan_as_null")]
    pub individual: f64,
    /// PoIs its group covers.
    #[serde(with = "nan_as_null")]
    pub group: f64,
    /// Episodic reward.
    #[serde(with = "nan_as_null")]
    pub reward: f64,
    /// Clipped surrogate, negated.
    #[serde(with = "nan_as_null")]
    pub policy_loss: f64,
    /// Value loss (of normalised returns).
    #[serde(with = "nan_as_null")]
    pub value_loss: f64,
    /// Entropy of the policy, nats.
    #[serde(with = "nan_as_null")]
    pub entropy: f64,
    /// Estimated KL divergence between the policies before and within an update, nats.
    #[serde(with = "nan_as_null")]
    pub kl: f64,
    /// Share of samples whose ratio left the clip range.
    #[serde(with = "nan_as_null")]
    pub clip_fraction: f64,
    /// Norm of the actor's gradient before clipping.
    #[serde(with = "nan_as_null")]
    pub actor_gradient: f64,
    /// Norm of the critic's gradient before clipping.
    #[serde(with = "nan_as_null")]
    pub critic_gradient: f64,
    /// Share of the variance of returns that the values explain.
    #[serde(with = "nan_as_null")]
    pub explained_variance: f64,
    /// Learning rate.
    #[serde(with = "nan_as_null")]
    pub learning_rate: f64,
}

/// Title, label of the value axis, metric of the same name in evaluations, and value.
type ChartOf = (&'static str, &'static str, &'static str, fn(&RoundMetrics) -> f64);

impl RoundMetrics {
    /// The curves of the paper's figures 5 to 10, then those that tell how learning goes.
    pub const CHARTS: &[ChartOf] = &[
        ("Episodic reward", "reward", "reward", |r| r.reward),
        ("Coverage index", "share of PoIs", "coverage", |r| r.coverage),
        ("Energy index", "0.5 hovering, 1 full speed", "energy", |r| r.energy),
        ("Policy loss", "clipped surrogate", "", |r| r.policy_loss),
        ("Individual covered PoIs", "PoIs a UAV", "individual", |r| r.individual),
        ("Group covered PoIs", "PoIs a group", "group", |r| r.group),
        ("Coverage, last step", "share of PoIs", "coverage_last", |r| r.coverage_last),
        ("Entropy of the policy", "nats", "", |r| r.entropy),
        ("Value loss", "of normalised returns", "", |r| r.value_loss),
        ("Explained variance", "of returns", "", |r| r.explained_variance),
        ("KL divergence", "nats", "", |r| r.kl),
        ("Clip fraction", "share of samples", "", |r| r.clip_fraction),
        ("Learning rate", "", "", |r| r.learning_rate),
    ];

    /// Tags and values for TensorBoard.
    #[must_use]
    pub fn curves(&self) -> [(&'static str, f64); 15] {
        [
            ("episode/reward", self.reward),
            ("episode/coverage", self.coverage),
            ("episode/coverage_last", self.coverage_last),
            ("episode/energy", self.energy),
            ("episode/individual", self.individual),
            ("episode/group", self.group),
            ("loss/policy", self.policy_loss),
            ("loss/value", self.value_loss),
            ("loss/entropy", self.entropy),
            ("learning/kl", self.kl),
            ("learning/clip_fraction", self.clip_fraction),
            ("learning/actor_gradient", self.actor_gradient),
            ("learning/critic_gradient", self.critic_gradient),
            ("learning/explained_variance", self.explained_variance),
            ("learning/learning_rate", self.learning_rate),
        ]
    }
}
