//! The rollouts of all workers as one training set, and its minibatches.

use super::ppo_loss::Sample;
use crate::rollout::{RolloutBuffer, RolloutWorker, ValueNorm, mean_and_deviation};
use covey_env::random::{below, stream};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// One world at one step of a rollout: minibatches are of whole world-steps, since the graph
/// layer needs all UAVs of a world.
#[derive(Clone, Copy)]
pub struct WorldStep {
    /// UAVs in that world.
    pub uavs: u32,
    /// Number of its worker.
    pub worker: u32,
    /// Index of its first UAV in the worker's [`RolloutBuffer`].
    pub first: u32,
}

impl WorldStep {
    /// Indices of its UAVs in the worker's [`RolloutBuffer`].
    pub const fn indices(&self) -> Range<usize> {
        self.first as usize..(self.first + self.uavs) as usize
    }
}

/// The rollouts of all workers, with what normalises them.
pub struct RolloutBatch<'w> {
    workers: &'w [RolloutWorker],
    /// Mean and standard deviation of all advantages.
    advantage_moments: (f64, f64),
    /// By which the critic's targets are normalised.
    value_norm: ValueNorm,
}

impl<'w> RolloutBatch<'w> {
    /// Of workers that have collected a rollout.
    pub fn new(workers: &'w [RolloutWorker], value_norm: ValueNorm) -> Self {
        let advantages: Vec<f32> = workers.iter().flat_map(|w| &w.buffer().advantages).copied().collect();
        Self { workers, advantage_moments: mean_and_deviation(&advantages), value_norm }
    }

    /// The buffers of all workers, in order.
    pub fn buffers(&self) -> impl Iterator<Item = &'w RolloutBuffer> + use<'w> {
        self.workers.iter().map(RolloutWorker::buffer)
    }

    /// The buffer that a world-step lies in.
    pub const fn buffer(&self, world_step: &WorldStep) -> &'w RolloutBuffer {
        self.workers[world_step.worker as usize].buffer()
    }

    /// All world-steps, in the order of workers, steps and worlds.
    fn world_steps(&self) -> Vec<WorldStep> {
        let mut all = Vec::new();
        for (worker, buffer) in self.buffers().enumerate() {
            let (count, uavs) = (buffer.num_envs() * buffer.steps(), buffer.uavs());
            let world_step = |k| WorldStep { uavs: uavs as u32, worker: worker as u32, first: (k * uavs) as u32 };
            all.extend((0..count).map(world_step));
        }
        all
    }

    /// The samples of a world-step, one a UAV.
    pub fn samples(&self, world_step: &WorldStep) -> impl Iterator<Item = Sample> {
        let buffer = self.buffer(world_step);
        world_step.indices().map(|at| self.sample(buffer, at))
    }

    fn sample(&self, buffer: &RolloutBuffer, at: usize) -> Sample {
        let (mean, deviation) = self.advantage_moments;
        Sample {
            action: buffer.actions[at].index(),
            expert_action: buffer.expert_actions[at].index(),
            log_prob: buffer.log_probs[at],
            advantage: ((f64::from(buffer.advantages[at]) - mean) / (deviation + 1e-8)) as f32,
            target: self.value_norm.normalise(buffer.returns[at]),
        }
    }
}

/// Samples of some world-steps: their UAVs.
pub fn count_samples(world_steps: &[WorldStep]) -> usize {
    world_steps.iter().map(|w| w.uavs as usize).sum()
}

/// The world-steps of a rollout, to be shuffled and cut into minibatches once an epoch.
pub struct Minibatches {
    world_steps: Vec<WorldStep>,
    count: usize,
    random: ChaCha8Rng,
}

impl Minibatches {
    /// As many minibatches as come nearest to `minibatch` samples each. Seed and number of the
    /// update name the random stream that shuffles.
    pub fn new(rollout: &RolloutBatch<'_>, minibatch: usize, seed: u64, update: u64) -> Self {
        let world_steps = rollout.world_steps();
        let samples = count_samples(&world_steps);
        let count = ((samples + minibatch / 2) / minibatch).clamp(1, world_steps.len());
        Self { world_steps, count, random: stream("ppo shuffle", seed, update) }
    }

    /// Shuffles (Fisher and Yates) and returns how many minibatches there are.
    pub fn shuffle(&mut self) -> usize {
        for k in (1..self.world_steps.len()).rev() {
            self.world_steps.swap(k, below(&mut self.random, k as u32 + 1) as usize);
        }
        self.count
    }

    /// Minibatch `m`, whose world-steps may be put into another order.
    pub fn get_mut(&mut self, m: usize) -> &mut [WorldStep] {
        let [from, to] = [m, m + 1].map(|m| m * self.world_steps.len() / self.count);
        &mut self.world_steps[from..to]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use std::collections::BTreeSet;

    #[test]
    fn an_epoch_has_every_world_step_once_in_even_minibatches() {
        let s = Settings { uavs: 3, uavs_max: 0, steps: 4, rollout_steps: 4, ..Settings::default() };
        let workers = [(0, 2), (1, 3)].map(|(k, num_envs)| RolloutWorker::new(&s, k, num_envs).expect("worlds"));
        let rollout = RolloutBatch::new(&workers, ValueNorm::default());
        // 5 worlds, 4 steps and 3 UAVs are 60 samples.
        let epochs = |seed| {
            let mut minibatches = Minibatches::new(&rollout, 20, seed, 0);
            [0, 1].map(|_| {
                let count = minibatches.shuffle();
                (0..count).map(|m| minibatches.get_mut(m).to_vec()).collect::<Vec<_>>()
            })
        };
        let names = |epoch: &[Vec<WorldStep>]| epoch.concat().iter().map(|w| (w.worker, w.first)).collect::<Vec<_>>();
        let [first, second] = epochs(1);
        for epoch in [&first, &second] {
            assert_eq!(epoch.iter().map(|m| count_samples(m)).collect::<Vec<_>>(), [18, 21, 21]);
            assert_eq!(names(epoch).into_iter().collect::<BTreeSet<_>>().len(), 20);
        }
        assert_ne!(names(&first), names(&second), "epochs are shuffled");
        assert_eq!(names(&first), names(&epochs(1)[0]), "the seed names the shuffle");
        assert_ne!(names(&first), names(&epochs(2)[0]));
    }
}
