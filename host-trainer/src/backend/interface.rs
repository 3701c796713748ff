//! The trait of backends.

use crate::optim::{Learner, LossSums, PpoLoss, RolloutBatch, WorldStep};
use crate::rollout::{RolloutWorker, ValueNorm, Workers};
use crate::settings::Settings;
use covey_net::{ActorCritic, EngineError};

/// How a rollout is to be collected.
pub struct Collection<'c> {
    /// The settings of the run.
    pub settings: &'c Settings,
    /// By which the critic's outputs become values in units of reward.
    pub value_norm: ValueNorm,
    /// Whether the expert's actions are recorded for behaviour cloning.
    pub cloning: bool,
}

/// Computes actor and critic for rollouts and updates.
///
/// Everything else (worlds, sampling, the loss by logits and values, the optimiser) is the same
/// for all backends. Methods that compute on a device fail when it does; those on CPUs never do.
pub trait Backend: Send {
    /// What it computes on, for messages and reports.
    fn name(&self) -> String;

    /// Takes the learner's present parameters. To be called whenever they have changed.
    fn load_parameters(&mut self, learner: &Learner);

    /// Collects a rollout in the worlds of all workers, with actions sampled by the actor and
    /// states valued by the critic, and computes its advantages.
    fn collect(
        &mut self,
        learner: &Learner,
        collection: &Collection<'_>,
        rollout_workers: &mut [RolloutWorker],
        threads: &Workers,
    ) -> Result<(), EngineError>;

    /// Prepares for [`Self::minibatch_gradient`] of minibatches of this rollout.
    fn begin_update(&mut self, rollout: &RolloutBatch<'_>);

    /// Computes the gradient of the mean loss of a minibatch by all parameters, for
    /// [`Self::partial_gradients`], and returns the terms of the loss. It may put the world-steps
    /// into another order.
    fn minibatch_gradient(
        &mut self,
        learner: &Learner,
        rollout: &RolloutBatch<'_>,
        loss: &PpoLoss,
        minibatch: &mut [WorldStep],
        threads: &Workers,
    ) -> Result<LossSums, EngineError>;

    /// The gradient of the last minibatch in one or several parts, whose sum in their order it is.
    fn partial_gradients(&mut self) -> &mut [ActorCritic<Vec<f32>>];

    /// Counts from now on the multiply-adds of minibatch gradients, those with a zero left out.
    fn start_counting(&mut self) {}

    /// The multiply-adds counted since [`Self::start_counting`], and an end to counting. Devices
    /// count none.
    fn take_count(&mut self) -> u64 {
        0
    }
}
