//! Buffers in which one thread runs both networks forward and backward.

use crate::optim::{Learner, LossSums, PpoLoss, RolloutBatch, Sample, WorldStep};
use crate::rollout::{RolloutWorker, ValueNorm};
use covey_env::{Neighbourhood, ObservationSlice};
use covey_net::{
    ActorCritic, ActorGradient, ActorPass, CriticGradient, CriticPass, Inputs, ParameterLayout, micro_batch_size,
};

/// Inputs, activations and gradients of one thread's work, kept from update to update.
#[derive(Clone, Debug)]
pub struct Workspace {
    inputs: Inputs,
    /// The actor's activations, then gradients by them.
    pub actor: ActorPass,
    /// The critic's activations, then gradients by them.
    pub critic: CriticPass,
    actor_gradient: ActorGradient,
    critic_gradient: CriticGradient,
    samples: Vec<Sample>,
    /// Multiply-adds of minibatch gradients, those with a zero left out; counted if there is a
    /// number.
    pub multiply_adds: Option<u64>,
}

impl Workspace {
    /// For networks of these layouts, which take `inputs` like these.
    pub fn new(layouts: &ActorCritic<ParameterLayout>, inputs: Inputs) -> Self {
        Self {
            inputs,
            actor: ActorPass::new(&layouts.actor),
            critic: CriticPass::new(&layouts.critic),
            actor_gradient: ActorGradient::new(&layouts.actor),
            critic_gradient: CriticGradient::new(&layouts.critic),
            samples: Vec::new(),
            multiply_adds: None,
        }
    }

    /// Takes the observations of worlds of `uavs` UAVs as inputs.
    pub fn set_inputs(&mut self, uavs: usize, observations: ObservationSlice<'_>, neighbours: &[Neighbourhood]) {
        self.inputs.clear(uavs);
        self.inputs.push(observations, neighbours);
    }

    /// Computes logits and values of the inputs.
    pub fn forward(&mut self, learner: &Learner) {
        self.actor.forward(&learner.actor.network, &self.inputs);
        self.critic.forward(&learner.critic.network, &self.inputs);
    }

    /// Adds to the gradients of the parameters, once logits and values hold gradients by them.
    pub fn backward(&mut self, learner: &Learner) {
        self.actor.backward(&learner.actor.network, &self.inputs, &mut self.actor_gradient);
        self.critic.backward(&learner.critic.network, &self.inputs, &mut self.critic_gradient);
    }

    /// Sets the gradients of the parameters to zero.
    pub fn clear_gradients(&mut self) {
        self.actor_gradient.clear();
        self.critic_gradient.clear();
    }

    /// Writes the gradients of the parameters as flat vectors.
    pub fn store_gradients(&self, learner: &Learner, gradients: &mut ActorCritic<Vec<f32>>) {
        self.actor_gradient.store(&learner.actor.parameters, &mut gradients.actor);
        self.critic_gradient.store(&mut gradients.critic);
    }

    /// Values the states before step `t` of a worker's rollout and, if the rollout has this step,
    /// samples its actions.
    pub fn act(&mut self, learner: &Learner, worker: &mut RolloutWorker, t: usize, norm: &ValueNorm) {
        let (uavs, num_envs) = (worker.buffer().uavs(), worker.buffer().num_envs());
        let micro_batch = micro_batch_size(uavs, num_envs);
        for first in (0..num_envs).step_by(micro_batch) {
            let worlds = first..(first + micro_batch).min(num_envs);
            let buffer = worker.buffer();
            let indices = buffer.worlds(t, &worlds);
            self.set_inputs(uavs, buffer.observations.part(indices.clone()), &buffer.neighbours[indices]);
            self.critic.forward(&learner.critic.network, &self.inputs);
            worker.store_values(t, &worlds, self.critic.values().values(), norm);
            if t < worker.buffer().steps() {
                self.actor.forward(&learner.actor.network, &self.inputs);
                worker.sample_actions(t, worlds, self.actor.logits().values());
            }
        }
    }

    /// Adds the gradients of some world-steps of a minibatch of `minibatch` samples. The
    /// world-steps must be sorted by number of UAVs: a micro-batch is of worlds of one size.
    pub fn accumulate(
        &mut self,
        learner: &Learner,
        rollout: &RolloutBatch<'_>,
        loss: &PpoLoss,
        world_steps: &[WorldStep],
        minibatch: usize,
    ) -> LossSums {
        let mut sums = LossSums::default();
        let by_size = world_steps.chunk_by(|a, b| a.uavs == b.uavs);
        let micro_batches = by_size.flat_map(|w| w.chunks(micro_batch_size(w[0].uavs as usize, w.len())));
        for micro_batch in micro_batches {
            self.inputs.clear(micro_batch[0].uavs as usize);
            self.samples.clear();
            for world_step in micro_batch {
                let (buffer, indices) = (rollout.buffer(world_step), world_step.indices());
                self.inputs.push(buffer.observations.part(indices.clone()), &buffer.neighbours[indices]);
                self.samples.extend(rollout.samples(world_step));
            }
            self.forward(learner);
            if let Some(sum) = &mut self.multiply_adds {
                let (actor, critic) = (self.actor.multiply_adds(&self.inputs), self.critic.multiply_adds(&self.inputs));
                *sum += actor.iter().chain(&critic).sum::<u64>();
            }
            let (logits, values) = (self.actor.logits_mut(), self.critic.values_mut());
            loss.backward(logits, values, &self.samples, minibatch, &mut sums);
            self.backward(learner);
        }
        sums
    }
}
