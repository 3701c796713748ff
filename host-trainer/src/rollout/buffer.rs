//! The tensors of one rollout.

use super::gae::gae;
use covey_env::{Neighbourhood, ObservationBatch, ObservationForm, ObservationSlice};
use covey_net::GraphBatch;
use firmware_core::action::Action;
use std::ops::Range;

/// What a worker's UAVs observed and did in a rollout of T steps, and what it was worth. Every
/// array is laid out `[step][world][UAV]`. Observations, neighbours and values have T + 1 steps:
/// the last one is of the state after the rollout, with which the next rollout begins.
pub struct RolloutBuffer {
    steps: usize,
    num_envs: usize,
    uavs: usize,
    /// Observations, T + 1 steps.
    pub observations: ObservationBatch,
    /// Neighbours that each UAV keeps, T + 1 steps.
    pub neighbours: Vec<Neighbourhood>,
    /// Actions taken.
    pub actions: Vec<Action>,
    /// Actions of the expert that behaviour cloning imitates; up to date only in rollouts that
    /// asked for them.
    pub expert_actions: Vec<Action>,
    /// Log-probabilities of the actions taken, when they were taken.
    pub log_probs: Vec<f32>,
    /// Training rewards.
    pub rewards: Vec<f32>,
    /// The critic's values in units of reward, T + 1 steps.
    pub values: Vec<f32>,
    /// Advantages in units of reward.
    pub advantages: Vec<f32>,
    /// Returns (advantage + value) in units of reward.
    pub returns: Vec<f32>,
}

impl RolloutBuffer {
    /// For rollouts of `steps` steps in `num_envs` worlds of `uavs` UAVs each.
    pub fn new(form: ObservationForm, steps: usize, num_envs: usize, uavs: usize) -> Self {
        let mut buffer = Self {
            steps,
            num_envs,
            uavs: 0,
            observations: ObservationBatch::new(form, 0),
            neighbours: Vec::new(),
            actions: Vec::new(),
            expert_actions: Vec::new(),
            log_probs: Vec::new(),
            rewards: Vec::new(),
            values: Vec::new(),
            advantages: Vec::new(),
            returns: Vec::new(),
        };
        buffer.resize(uavs);
        buffer
    }

    /// Makes room for swarms of `uavs` UAVs; what is in the buffer then means nothing.
    pub fn resize(&mut self, uavs: usize) {
        self.uavs = uavs;
        let (agents, samples) = (self.agents(), self.agents() * self.steps);
        self.observations.resize(samples + agents);
        self.neighbours.resize(samples + agents, Neighbourhood::default());
        self.values.resize(samples + agents, 0.0);
        for actions in [&mut self.actions, &mut self.expert_actions] {
            actions.resize(samples, Action::COAST);
        }
        let Self { log_probs, rewards, advantages, returns, .. } = self;
        for numbers in [log_probs, rewards, advantages, returns] {
            numbers.resize(samples, 0.0);
        }
    }

    /// Steps of a rollout, T.
    pub const fn steps(&self) -> usize {
        self.steps
    }

    /// Worlds side by side.
    pub const fn num_envs(&self) -> usize {
        self.num_envs
    }

    /// UAVs in each world.
    pub const fn uavs(&self) -> usize {
        self.uavs
    }

    /// UAVs in all worlds: samples of a step.
    pub const fn agents(&self) -> usize {
        self.num_envs * self.uavs
    }

    /// Indices of step `t`.
    pub const fn step(&self, t: usize) -> Range<usize> {
        t * self.agents()..(t + 1) * self.agents()
    }

    /// Indices of some worlds in step `t`.
    pub const fn worlds(&self, t: usize, worlds: &Range<usize>) -> Range<usize> {
        t * self.agents() + worlds.start * self.uavs..t * self.agents() + worlds.end * self.uavs
    }

    /// Makes the state after the last rollout the first one of the next.
    pub fn carry_over(&mut self) {
        let last = self.step(self.steps);
        self.observations.copy_within(last.clone(), 0);
        self.neighbours.copy_within(last, 0);
    }

    /// Observations and neighbours at these indices, which must be whole world-steps.
    ///
    /// # Panics
    /// When the observations are in cells, which no device takes.
    pub fn graph_batch(&self, indices: Range<usize>) -> GraphBatch<'_> {
        let ObservationSlice::Compact(observations) = self.observations.part(indices.clone()) else {
            panic!("runs with observations in cells are refused before a device is asked")
        };
        GraphBatch { uavs: self.uavs, observations, neighbours: &self.neighbours[indices] }
    }

    /// Computes advantages and returns of the rollout. `bootstrap` says whether the value of the
    /// state after the rollout counts.
    pub fn compute_gae(&mut self, gamma: f32, lambda: f32, bootstrap: bool) {
        let agents = self.agents();
        let (mut rewards, mut values) = (vec![0.0; self.steps], vec![0.0; self.steps + 1]);
        let mut advantages = vec![0.0; self.steps];
        for k in 0..agents {
            rewards.iter_mut().enumerate().for_each(|(t, r)| *r = self.rewards[t * agents + k]);
            values.iter_mut().enumerate().for_each(|(t, v)| *v = self.values[t * agents + k]);
            if !bootstrap {
                values[self.steps] = 0.0;
            }
            gae(&rewards, &values, gamma, lambda, &mut advantages);
            for t in 0..self.steps {
                self.advantages[t * agents + k] = advantages[t];
                self.returns[t * agents + k] = advantages[t] + values[t];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn buffer() -> RolloutBuffer {
        RolloutBuffer::new(ObservationForm::Compact, 2, 3, 2)
    }

    #[test]
    fn indices_are_by_step_world_and_uav() {
        let buffer = buffer();
        assert_eq!((buffer.agents(), buffer.step(1)), (6, 6..12));
        assert_eq!(buffer.worlds(1, &(1..3)), 8..12);
    }

    #[test]
    fn every_uav_has_a_return_of_its_own_and_the_last_value_counts_on_demand() {
        let mut buffer = buffer();
        buffer.rewards.iter_mut().enumerate().for_each(|(k, r)| *r = k as f32);
        buffer.values.fill(1.0);
        for (bootstrap, last) in [(true, 1.0), (false, 0.0)] {
            buffer.compute_gae(1.0, 1.0, bootstrap);
            for k in 0..6 {
                // Rewards k and k + 6, then the value of the last state.
                assert_eq!(buffer.returns[k], 2.0 * k as f32 + 6.0 + last);
                assert_eq!(buffer.returns[k + 6], k as f32 + 6.0 + last);
            }
        }
    }
}
