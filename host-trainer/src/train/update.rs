//! The update: several epochs over a rollout in minibatches.

use crate::backend::Backend;
use crate::optim::{Learner, LossSums, Minibatches, PpoLoss, RolloutBatch};
use crate::rollout::Workers;
use covey_net::{ActorCritic, EngineError};

/// How to update.
pub struct UpdatePlan {
    /// Number of the update in the run, from 0.
    pub number: u64,
    /// Seed of the shuffles.
    pub seed: u64,
    /// Passes over the rollout.
    pub epochs: u32,
    /// Samples in a minibatch, about.
    pub minibatch: usize,
    /// Adam's learning rate.
    pub learning_rate: f64,
    /// Greatest norm of each network's gradient.
    pub max_gradient_norm: f64,
    /// Coefficients of the loss.
    pub loss: PpoLoss,
}

/// What updates gave, summed up.
#[derive(Clone, Copy, Debug, Default)]
pub struct UpdateSums {
    /// Loss terms, summed over the samples of all epochs.
    pub losses: LossSums,
    /// Norms of the gradients before clipping, summed over minibatches.
    pub gradient_norms: ActorCritic<f64>,
    /// Number of minibatches.
    pub minibatches: f64,
}

impl UpdateSums {
    /// Adds those of another update.
    pub fn add(&mut self, o: &Self) {
        self.losses.add(&o.losses);
        self.add_norms(o.gradient_norms, o.minibatches);
    }

    fn add_norms(&mut self, norms: ActorCritic<f64>, minibatches: f64) {
        self.gradient_norms.actor += norms.actor;
        self.gradient_norms.critic += norms.critic;
        self.minibatches += minibatches;
    }
}

/// Runs an update of the learner, whose parameters the backend has before and after.
///
/// # Errors
/// When the backend's device fails.
pub fn update(
    learner: &mut Learner,
    backend: &mut dyn Backend,
    rollout: &RolloutBatch<'_>,
    plan: &UpdatePlan,
    threads: &Workers,
) -> Result<UpdateSums, EngineError> {
    backend.begin_update(rollout);
    let mut minibatches = Minibatches::new(rollout, plan.minibatch, plan.seed, plan.number);
    let mut sums = UpdateSums::default();
    for _ in 0..plan.epochs {
        for m in 0..minibatches.shuffle() {
            let minibatch = minibatches.get_mut(m);
            sums.losses.add(&backend.minibatch_gradient(learner, rollout, &plan.loss, minibatch, threads)?);
            let gradients = backend.partial_gradients();
            let norms = learner.step(gradients, plan.learning_rate, plan.max_gradient_norm, threads);
            backend.load_parameters(learner);
            sums.add_norms(norms, 1.0);
        }
    }
    Ok(sums)
}
