//! Policies that can be evaluated on held-out worlds.

use super::any_actor::AnyActor;
use super::config::EvalConfig;
use super::reference::ReferencePolicy;
use super::row::EvalRow;
use super::watch::{UNWATCHED, Watch, Watched};
use crate::float_actor::{FloatActor, FloatPolicy};
use crate::settings::word_of;
use covey_env::baselines::Hover;
use covey_env::oracles::spawn_parked;
use covey_env::{ActorPolicy, Evaluation, ScenarioError, evaluate, evaluate_with, policy_seed};
use firmware_core::actor::{Actor, CellsActor};

/// A policy that can be evaluated.
pub enum EvalPolicy<'a> {
    /// The on-board int8 actor.
    Int8(&'a Actor<'a>),
    /// The on-board int8 actor that observes cells.
    Int8Cells(&'a CellsActor<'a>),
    /// The trained network in floats.
    Float(&'a FloatActor),
    /// A hand-written policy or an oracle.
    Reference(ReferencePolicy),
}

impl<'a> EvalPolicy<'a> {
    /// The on-board actor of either form of the observation.
    #[must_use]
    pub const fn of(actor: &'a AnyActor<'a>) -> Self {
        match actor {
            AnyActor::Compact(actor) => Self::Int8(actor),
            AnyActor::Cells(actor) => Self::Int8Cells(actor),
        }
    }

    /// Flies it in the worlds of `config`, on all threads; `name` goes into the row.
    ///
    /// # Errors
    /// When the scenario cannot be built.
    pub fn evaluate(&self, name: &str, config: &EvalConfig) -> Result<EvalRow, ScenarioError> {
        self.evaluate_watched(name, config, UNWATCHED)
    }

    /// [`Self::evaluate`] that tells `watch` how far it is.
    ///
    /// # Errors
    /// When the scenario cannot be built.
    pub fn evaluate_watched(
        &self,
        name: &str,
        config: &EvalConfig,
        watch: Watch<'_>,
    ) -> Result<EvalRow, ScenarioError> {
        let decide = if matches!(self, Self::Reference(_)) { "rule" } else { word_of(config.mode) };
        Ok(EvalRow::new(name, config, decide, &self.fly(config, watch)?))
    }

    fn fly(&self, config: &EvalConfig, watch: Watch<'_>) -> Result<Evaluation, ScenarioError> {
        let EvalConfig { scenario, seed, worlds, mode } = config;
        let (seed, mode, worlds) = (*seed, *mode, u64::from(*worlds));
        let own_seed = |index| policy_seed(seed, index);
        match self {
            Self::Int8(actor) => {
                let policy = |i| ActorPolicy::new(**actor, own_seed(i), mode);
                evaluate(scenario, seed, worlds, |i| Watched { policy: policy(i), watch })
            }
            Self::Int8Cells(actor) => {
                let policy = |i| ActorPolicy::new(**actor, own_seed(i), mode);
                evaluate(scenario, seed, worlds, |i| Watched { policy: policy(i), watch })
            }
            Self::Float(actor) => {
                let net = actor.network();
                let policy = |i| FloatPolicy::new(actor, &net, own_seed(i), mode);
                evaluate(scenario, seed, worlds, |i| Watched { policy: policy(i), watch })
            }
            Self::Reference(ReferencePolicy::Parked) => evaluate_with(scenario, worlds, |world, i| {
                spawn_parked(world, seed, i);
                Watched { policy: Hover, watch }
            }),
            Self::Reference(policy) => {
                evaluate(scenario, seed, worlds, |i| Watched { policy: policy.in_world(seed, i), watch })
            }
        }
    }
}
