//! Worlds that run side by side.

use super::observer::TrainingObserver;
use crate::settings::Settings;
use covey_env::baselines::recommended_action as expert_action;
use covey_env::radio::RadioWorldError;
use covey_env::{EpisodeMetrics, Neighbourhood, ObservationBatch, ObservationSlice, Scenario, World};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::random::action_draw;
use std::ops::Range;

/// Some of the run's worlds, all with the same number of UAVs, and their observers. Arrays that
/// cross its interface are laid out `[world][UAV]`.
pub struct VecEnv {
    /// Number of the worker in the run, from 0.
    index: u32,
    uavs: usize,
    worlds: Vec<World>,
    /// Seed of the on-board random numbers in the present episode of each world.
    policy_seeds: Vec<u64>,
    observers: Vec<TrainingObserver>,
}

/// Seed of the on-board random numbers of training episode `episode`.
fn training_policy_seed(seed: u64, episode: u64) -> u64 {
    // SplitMix64's increment keeps neighbouring episodes far apart; the board mixes on.
    (seed ^ 0x7261_696e).wrapping_add(episode.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

impl VecEnv {
    /// The `num_envs` worlds of worker `index`.
    ///
    /// # Errors
    /// When the scenario or the radio model cannot be built.
    pub fn new(s: &Settings, index: u32, num_envs: usize) -> Result<Self, RadioWorldError> {
        let mut env =
            Self { index, uavs: 0, worlds: Vec::new(), policy_seeds: vec![0; num_envs], observers: Vec::new() };
        env.resize(s, s.uavs.into())?;
        Ok(env)
    }

    /// Makes the worlds anew, for swarms of `uavs` UAVs.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn resize(&mut self, s: &Settings, uavs: usize) -> Result<(), RadioWorldError> {
        let num_envs = self.policy_seeds.len();
        let scenario =
            |world| Scenario { uavs, distribution: s.distribution_in(self.index, world, num_envs), ..s.world() };
        self.worlds = (0..num_envs).map(|world| World::new(&scenario(world))).collect::<Result<_, _>>()?;
        self.observers = vec![TrainingObserver::new(s, uavs)?; num_envs];
        self.uavs = uavs;
        Ok(())
    }

    /// UAVs in each world.
    pub const fn uavs(&self) -> usize {
        self.uavs
    }

    /// Worlds.
    pub const fn num_envs(&self) -> usize {
        self.policy_seeds.len()
    }

    /// Begins an episode in every world, numbered from `first_episode`.
    pub fn reset(&mut self, s: &Settings, first_episode: u64) {
        for (k, world) in self.worlds.iter_mut().enumerate() {
            let episode = first_episode + k as u64;
            world.reset(s.seed, episode);
            self.policy_seeds[k] = training_policy_seed(s.seed, episode);
            self.observers[k].begin(s, self.policy_seeds[k]);
        }
    }

    /// Writes the observations and kept neighbours of the present states to the indices from
    /// `at` on. Call it once a step.
    pub fn observe(&mut self, at: usize, observations: &mut ObservationBatch, neighbours: &mut [Neighbourhood]) {
        let n = self.uavs;
        for (k, world) in self.worlds.iter().enumerate() {
            let indices = at + k * n..at + (k + 1) * n;
            let (o, l) = (observations.part_mut(indices.clone()), &mut neighbours[indices]);
            self.observers[k].observe(world, o, l);
        }
    }

    /// Uniform random numbers, 0 to below 1, by which the UAVs of some worlds choose their next
    /// actions: those of the board's own random stream.
    pub fn action_draws(&self, worlds: Range<usize>, draws: &mut Vec<f64>) {
        draws.clear();
        for (world, seed) in self.worlds[worlds.clone()].iter().zip(&self.policy_seeds[worlds]) {
            let draw = |id| action_draw(*seed, id as u16, world.steps_done());
            draws.extend((0..self.uavs).map(|id| f64::from(draw(id)) / (1u64 << 32) as f64));
        }
    }

    /// Uniformly random actions for all UAVs.
    pub fn random_actions(&self, actions: &mut [Action]) {
        for (k, action) in actions.iter_mut().enumerate() {
            let (world, id) = (k / self.uavs, (k % self.uavs) as u16);
            let draw = u64::from(action_draw(self.policy_seeds[world], id, self.worlds[world].steps_done()));
            let index = ((draw * ACTIONS as u64) >> 32) as u8;
            *action = Action::new(index).unwrap_or(Action::COAST);
        }
    }

    /// What the expert would do: it flies to the place that the compact observation names the
    /// best. There is no expert for observations in cells; their actions stay as they are.
    pub fn expert_actions(&self, observations: ObservationSlice<'_>, actions: &mut [Action]) {
        let ObservationSlice::Compact(observations) = observations else { return };
        for (k, (action, observation)) in actions.iter_mut().zip(observations).enumerate() {
            *action = expert_action(observation, self.worlds[k / self.uavs].velocity(k % self.uavs));
        }
    }

    /// Moves every world by a step and writes the training rewards: the scenario's, of which
    /// `team_share` is replaced by the mean over the world's UAVs, less `overlap_cost`.
    pub fn step(&mut self, s: &Settings, actions: &[Action], rewards: &mut [f32]) {
        let n = self.uavs;
        let (team_share, overlap_cost) = (s.team_share as f32, s.overlap_cost as f32);
        let rows = actions.chunks_exact(n).zip(rewards.chunks_exact_mut(n));
        for (world, (actions, rewards)) in self.worlds.iter_mut().zip(rows) {
            world.step(actions);
            let own_rewards = world.rewards();
            let team = own_rewards.iter().sum::<f32>() / n as f32;
            let costs = world.overlaps().iter().zip(world.energy());
            for ((reward, own), (&overlap, energy)) in rewards.iter_mut().zip(own_rewards).zip(costs) {
                *reward = own + team_share * (team - own) - overlap_cost * overlap as f32 / energy;
            }
        }
    }

    /// Whether the episodes are over. All worlds have the same number of steps.
    pub fn done(&self) -> bool {
        self.worlds.first().is_some_and(World::done)
    }

    /// Whether all its worlds are of the configured scenario. Those of every second worker are
    /// randomised when `uavs_max` or `other_distribution_share` is above 0; the curves leave
    /// these out.
    pub const fn is_configured_scenario(&self, s: &Settings) -> bool {
        self.index.is_multiple_of(2) || s.uavs_max == 0 && s.other_distribution_share == 0.0
    }

    /// Metrics of the present episode of every world, up to the present step.
    pub fn metrics(&self) -> impl Iterator<Item = EpisodeMetrics> {
        self.worlds.iter().map(World::metrics)
    }
}
