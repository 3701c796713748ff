//! One worker: some worlds and the buffer of their rollouts.

use super::buffer::RolloutBuffer;
use super::categorical::sample;
use super::value_norm::ValueNorm;
use super::vec_env::VecEnv;
use crate::settings::Settings;
use covey_env::radio::RadioWorldError;
use covey_net::kernel::padded;
use std::ops::Range;

/// One of the `shards` of a run: its part of the worlds, and what they went through in the
/// present rollout. It runs on one thread at a time; what it computes does not depend on which.
pub struct RolloutWorker {
    env: VecEnv,
    buffer: RolloutBuffer,
    /// Random numbers of a batch of actions.
    draws: Vec<f64>,
}

impl RolloutWorker {
    /// Worker `index` of the run, with `num_envs` worlds.
    ///
    /// # Errors
    /// When the scenario or the radio model cannot be built.
    pub fn new(s: &Settings, index: u32, num_envs: usize) -> Result<Self, RadioWorldError> {
        let env = VecEnv::new(s, index, num_envs)?;
        let buffer = RolloutBuffer::new(s.observation, s.rollout_steps as usize, num_envs, env.uavs());
        Ok(Self { env, buffer, draws: Vec::new() })
    }

    /// Its worlds.
    pub const fn env(&self) -> &VecEnv {
        &self.env
    }

    /// What they went through.
    pub const fn buffer(&self) -> &RolloutBuffer {
        &self.buffer
    }

    /// Begins new episodes of `uavs` UAVs each, numbered from `first_episode`.
    ///
    /// # Panics
    /// When no world can have so many UAVs.
    pub fn reset(&mut self, s: &Settings, first_episode: u64, uavs: u16) {
        let uavs = usize::from(uavs);
        if uavs != self.env.uavs() {
            self.env.resize(s, uavs).expect("settings allow these numbers of UAVs");
            self.buffer.resize(uavs);
        }
        self.env.reset(s, first_episode);
        self.observe(self.buffer.steps());
    }

    /// Writes the observations of the present state as those before step `t`.
    fn observe(&mut self, t: usize) {
        let at = self.buffer.step(t).start;
        self.env.observe(at, &mut self.buffer.observations, &mut self.buffer.neighbours);
    }

    /// Begins a rollout where the last one ended. Then, for every step `t` from 0 to
    /// `rollout_steps`: [`Self::store_values`] and, but for the last, [`Self::sample_actions`]
    /// for all worlds, and [`Self::advance`].
    pub fn begin_rollout(&mut self) {
        self.buffer.carry_over();
    }

    /// Stores the values of some worlds before step `t`: the critic's rows, 1 wide with padding.
    pub fn store_values(&mut self, t: usize, worlds: &Range<usize>, rows: &[f32], norm: &ValueNorm) {
        let indices = self.buffer.worlds(t, worlds);
        let outputs = rows.iter().step_by(padded(1));
        self.buffer.values[indices].iter_mut().zip(outputs).for_each(|(v, &output)| *v = norm.denormalise(output));
    }

    /// Draws the actions of some worlds in step `t` from their rows of logits, 17 wide with
    /// padding, and stores them with their log-probabilities.
    pub fn sample_actions(&mut self, t: usize, worlds: Range<usize>, rows: &[f32]) {
        let indices = self.buffer.worlds(t, &worlds);
        self.env.action_draws(worlds, &mut self.draws);
        let actions = &mut self.buffer.actions[indices.clone()];
        let log_probs = &mut self.buffer.log_probs[indices];
        sample(rows, &self.draws, |k, action, log_prob| {
            actions[k] = action;
            log_probs[k] = log_prob;
        });
    }

    /// Plays step `t` with the actions drawn; after the last one, computes advantages. With
    /// `cloning` the expert is asked too.
    pub fn advance(&mut self, t: usize, s: &Settings, cloning: bool) {
        if t < self.buffer.steps() {
            if cloning {
                let step = self.buffer.step(t);
                let actions = &mut self.buffer.expert_actions[step.clone()];
                self.env.expert_actions(self.buffer.observations.part(step), actions);
            }
            self.env_step(t, s);
        } else {
            // Episodes end by truncation, so that the last state's value may count. Without a
            // discount it has no bound.
            let bootstrap = !self.env.done() || (s.bootstrap_end && s.gamma < 1.0);
            self.buffer.compute_gae(s.gamma as f32, s.lambda as f32, bootstrap);
        }
    }

    /// Moves the worlds by the actions of step `t` and observes what comes of it.
    fn env_step(&mut self, t: usize, s: &Settings) {
        let step = self.buffer.step(t);
        self.env.step(s, &self.buffer.actions[step.clone()], &mut self.buffer.rewards[step]);
        self.observe(t + 1);
    }

    /// A rollout with uniformly random actions and without networks: the environment alone.
    pub fn random_rollout(&mut self, s: &Settings) {
        for t in 0..self.buffer.steps() {
            let step = self.buffer.step(t);
            self.env.random_actions(&mut self.buffer.actions[step]);
            self.env_step(t, s);
        }
    }
}
