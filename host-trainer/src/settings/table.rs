//! The table of settings.

use super::choice;
use covey_env::{ObservationForm, PoiDistribution};
use firmware_core::actor::Aggregation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The settings of a training run. Distances are in u, times in steps of the scenario.
///
/// The documentation of a field is what users read, and the bounds beside it are checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Settings {
    /// UAVs in a world.
    #[schemars(range(min = 1, max = 10_000))]
    pub uavs: u16,
    /// Fewest UAVs in the worlds of every second shard: each round draws their number anew, up
    /// to `uavs_max`. The curves are those of the other worlds.
    #[schemars(range(min = 1, max = 10_000))]
    pub uavs_min: u16,
    /// Most UAVs in the worlds of every second shard. 0: all worlds have `uavs`.
    #[schemars(range(min = 0, max = 10_000))]
    pub uavs_max: u16,
    /// Share of the worlds of every second shard whose PoIs follow the other distribution.
    #[schemars(range(min = 0, max = 1))]
    pub other_distribution_share: f64,
    /// Points of interest in a world.
    #[schemars(range(min = 1, max = 60_000))]
    pub pois: u16,
    /// Distribution of the PoIs: "clustered" or "uniform".
    #[serde(with = "choice")]
    #[schemars(schema_with = "choice::schema::<PoiDistribution>")]
    pub poi_distribution: PoiDistribution,
    /// Steps of an episode.
    #[schemars(range(min = 1, max = 100_000))]
    pub steps: u32,
    /// Side of the map, u.
    #[schemars(range(min = 60, max = 10_000), extend("x-unit" = "u"))]
    pub side: f64,
    /// What UAVs observe: "compact", numbers made for the task, or "cells", the paper's id and
    /// position in binary and maps of what is around.
    #[serde(with = "choice")]
    #[schemars(schema_with = "choice::schema::<ObservationForm>")]
    pub observation: ObservationForm,
    /// Aggregation of neighbours' features: "none", "gcn", "gat", "gatv2" or "sage".
    #[serde(with = "choice")]
    #[schemars(schema_with = "choice::schema::<Aggregation>")]
    pub graph: Aggregation,
    /// Width of the first hidden layer, actor and critic.
    #[schemars(range(min = 2, max = 128), extend("multipleOf" = 2))]
    pub hidden: u16,
    /// Width of the feature that UAVs broadcast.
    #[schemars(range(min = 2, max = 64), extend("multipleOf" = 2))]
    pub feature: u16,
    /// Width of the hidden layer of the policy and value heads.
    #[schemars(range(min = 2, max = 128), extend("multipleOf" = 2))]
    pub head: u16,
    /// Steps for which a UAV keeps its tie-breaker: who goes first stays so for a whole flight
    /// when this is longer than one.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub tie_period: u32,
    /// Greatest share of messages between UAVs that is lost in training: each episode of each
    /// world draws its own from 0 to this. 0 for a radio that loses none.
    #[schemars(range(min = 0, max = 1))]
    pub radio_loss: f64,
    /// Greatest delay of those messages, whole steps: each episode of each world draws its own
    /// from 0 to this.
    #[schemars(range(min = 0, max = 2), extend("x-unit" = "steps"))]
    pub radio_delay: u32,
    /// Seed of everything random in the run.
    pub seed: u64,
    /// Training episodes, at most: whole rounds of `num_envs`, at least one.
    #[schemars(range(min = 1, max = 100_000_000))]
    pub episodes: u32,
    /// Worlds that run side by side: one round is an episode of each.
    #[schemars(range(min = 1, max = 65_536))]
    pub num_envs: u32,
    /// Steps between updates; must divide `steps`.
    #[schemars(range(min = 1, max = 100_000))]
    pub rollout_steps: u32,
    /// Passes over a rollout in an update.
    #[schemars(range(min = 1, max = 100))]
    pub epochs: u32,
    /// Agent samples in a minibatch (rounded to whole world-steps).
    #[schemars(range(min = 1, max = 10_000_000))]
    pub minibatch: u32,
    /// Parts into which worlds and minibatches are split. At most as many threads are of
    /// use; results depend on this number, never on the number of threads.
    #[schemars(range(min = 1, max = 256))]
    pub shards: u32,
    /// Adam's learning rate at the start.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub learning_rate: f64,
    /// Share of the learning rate that is left at the end (it falls linearly).
    #[schemars(range(min = 0, max = 1))]
    pub learning_rate_end: f64,
    /// Discount of future reward, per step. 1 with `lambda` 1 and `rollout_steps` = `steps` is
    /// the paper's return.
    #[schemars(range(min = 0, max = 1))]
    pub gamma: f64,
    /// Lambda of generalised advantage estimation.
    #[schemars(range(min = 0, max = 1))]
    pub lambda: f64,
    /// Whether the last state of an episode counts with its value (episodes end by
    /// truncation). With `gamma` 1 it never does, since that value has no bound.
    pub bootstrap_end: bool,
    /// Clip range of the probability ratio.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub clip: f64,
    /// Weight of the entropy bonus at the start.
    #[schemars(range(min = 0, max = 1))]
    pub entropy: f64,
    /// Weight of the entropy bonus at the end (it falls linearly).
    #[schemars(range(min = 0, max = 1))]
    pub entropy_end: f64,
    /// Greatest global norm of the actor's gradient, and of the critic's.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub gradient_norm: f64,
    /// Error (in standard deviations of the return) beyond which the value loss is linear.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub huber: f64,
    /// Share of the old mean and deviation of returns kept at each update.
    #[schemars(range(min = 0, max = 1))]
    pub value_norm_decay: f64,
    /// Share of a UAV's training reward that is replaced by the mean over all UAVs. The
    /// reported reward stays the scenario's.
    #[schemars(range(min = 0, max = 1))]
    pub team_share: f64,
    /// What a UAV pays in training for each PoI that it and exactly one other of its group
    /// cover, over its energy: 1 is what that takes from the other's individual coverage, which
    /// the scenario's reward leaves to the other alone. The reported reward stays the scenario's.
    #[schemars(range(min = 0, max = 10))]
    pub overlap_cost: f64,
    /// Weight of behaviour cloning at the start: of the cross-entropy to the action that flies to
    /// the place which the observation names the best. It falls linearly to 0; 0 learns from
    /// reward alone.
    #[schemars(range(min = 0, max = 100))]
    pub cloning_weight: f64,
    /// Episodes until the weight of behaviour cloning has fallen to 0.
    #[schemars(range(min = 1, max = 100_000_000))]
    pub cloning_episodes: u32,
    /// Decay of the exponential moving average (EMA) of the actor's weights: the share of it that
    /// is kept at each update. The average is what is exported. 0 exports the last weights.
    #[schemars(range(min = 0, max = 0.9999))]
    pub ema_decay: f64,
    /// The exported actor's logits are divided by this: below 1 it draws less at random than
    /// in training, above 1 more.
    #[schemars(range(min = 0.05, max = 20))]
    pub temperature: f64,
    /// Episodes between checkpoints.
    #[schemars(range(min = 1, max = 100_000_000))]
    pub checkpoint_every: u32,
    /// Held-out worlds of the evaluation at the end.
    #[schemars(range(min = 2, max = 100_000))]
    pub eval_worlds: u32,
    /// Seed of the held-out worlds.
    pub eval_seed: u64,
    /// Worlds flown to calibrate the quantisation.
    #[schemars(range(min = 1, max = 10_000))]
    pub calibration_worlds: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            uavs: 20,
            uavs_min: 10,
            uavs_max: 40,
            other_distribution_share: 0.25,
            pois: 120,
            poi_distribution: PoiDistribution::Clustered,
            steps: 100,
            side: 200.0,
            observation: ObservationForm::Compact,
            graph: Aggregation::Gcn,
            hidden: 128,
            feature: 64,
            head: 64,
            tie_period: 1_000_000,
            radio_loss: 0.0,
            radio_delay: 0,
            seed: 10,
            episodes: 6016,
            num_envs: 64,
            rollout_steps: 25,
            epochs: 5,
            minibatch: 4000,
            shards: 4,
            learning_rate: 8e-4,
            learning_rate_end: 0.02,
            gamma: 0.94,
            lambda: 0.95,
            bootstrap_end: true,
            clip: 0.2,
            entropy: 0.01,
            entropy_end: 0.0003,
            gradient_norm: 0.5,
            huber: 1.0,
            value_norm_decay: 0.9,
            team_share: 0.0,
            overlap_cost: 1.0,
            cloning_weight: 1.0,
            cloning_episodes: 960,
            ema_decay: 0.99,
            temperature: 0.8,
            checkpoint_every: 320,
            eval_worlds: 200,
            eval_seed: 777,
            calibration_worlds: 16,
        }
    }
}
