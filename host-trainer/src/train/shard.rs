//! One shard: some of the worlds, and what they went through in a rollout.

use super::advantage::{ValueNorm, advantages};
use super::link::Eyes;
use super::networks::{Networks, Workspace};
use super::softmax;
use crate::settings::Settings;
use covey_env::baselines::advice;
use covey_env::radio::RadioWorldError;
use covey_env::{EpisodeMetrics, Neighbourhood, ObservationBatch, ObservationSlice, Scenario, World};
use covey_net::kernel::padded;
use covey_net::{GraphBatch, worlds_in_pass};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::random::action_draw;
use std::ops::Range;

/// Worlds of a shard with the buffers of a rollout. Arrays are laid out
/// `[step][world][UAV]`.
pub struct Shard {
    number: u32,
    worlds: Vec<World>,
    policy_seeds: Vec<u64>,
    eyes: Vec<Eyes>,
    uavs: usize,
    steps: usize,
    /// Observations, one step more than the rollout has: the last is what comes next.
    pub observations: ObservationBatch,
    /// Kept neighbours, as `observations`.
    pub links: Vec<Neighbourhood>,
    /// Actions taken.
    pub actions: Vec<Action>,
    /// Actions that the observations advised, while they are asked.
    pub advice: Vec<Action>,
    /// Their log-probabilities.
    pub log_probabilities: Vec<f32>,
    rewards: Vec<f32>,
    values: Vec<f32>,
    /// Advantages, before normalisation.
    pub advantages: Vec<f32>,
    /// Returns in reward units.
    pub returns: Vec<f32>,
}

/// Seed of the on-board random numbers of training episode `episode`.
fn policy_seed(seed: u64, episode: u64) -> u64 {
    // SplitMix64's increment keeps neighbouring episodes far apart; the board mixes on.
    (seed ^ 0x7261_696e).wrapping_add(episode.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

impl Shard {
    /// Shard `number` of the run, of `count` worlds.
    ///
    /// # Errors
    /// When the scenario or the link cannot be built.
    pub fn new(s: &Settings, number: u32, count: usize) -> Result<Self, RadioWorldError> {
        let mut shard = Self {
            number,
            worlds: Vec::new(),
            policy_seeds: vec![0; count],
            eyes: Vec::new(),
            uavs: 0,
            steps: s.rollout_steps as usize,
            observations: ObservationBatch::new(s.observation, 0),
            links: Vec::new(),
            actions: Vec::new(),
            advice: Vec::new(),
            log_probabilities: Vec::new(),
            rewards: Vec::new(),
            values: Vec::new(),
            advantages: Vec::new(),
            returns: Vec::new(),
        };
        shard.resize(s, usize::from(s.uavs))?;
        Ok(shard)
    }

    /// Makes worlds and buffers for swarms of `uavs`.
    fn resize(&mut self, s: &Settings, uavs: usize) -> Result<(), RadioWorldError> {
        let count = self.policy_seeds.len();
        let (row, cells) = (count * uavs, count * uavs * self.steps);
        let scenario =
            |world| Scenario { uavs, distribution: s.distribution_in(self.number, world, count), ..s.world() };
        self.worlds = (0..count).map(|world| World::new(&scenario(world))).collect::<Result<_, _>>()?;
        self.eyes = vec![Eyes::new(s, uavs)?; count];
        self.uavs = uavs;
        self.observations.resize(cells + row);
        self.links.resize(cells + row, Neighbourhood::default());
        self.values.resize(cells + row, 0.0);
        for actions in [&mut self.actions, &mut self.advice] {
            actions.resize(cells, Action::COAST);
        }
        let Self { log_probabilities, rewards, advantages, returns, .. } = self;
        for numbers in [log_probabilities, rewards, advantages, returns] {
            numbers.resize(cells, 0.0);
        }
        Ok(())
    }

    /// UAVs in each of its worlds.
    #[must_use]
    pub const fn uavs(&self) -> usize {
        self.uavs
    }

    /// Worlds in this shard.
    #[must_use]
    pub fn worlds(&self) -> usize {
        self.worlds.len()
    }

    /// UAVs in all its worlds.
    #[must_use]
    pub fn row(&self) -> usize {
        self.worlds.len() * self.uavs
    }

    /// Begins new episodes of `uavs` UAVs each, numbered from `first`.
    ///
    /// # Panics
    /// When no world can have so many.
    pub fn reset(&mut self, s: &Settings, first: u64, uavs: u16) {
        if usize::from(uavs) != self.uavs {
            self.resize(s, uavs.into()).expect("settings allow these numbers of UAVs");
        }
        for (k, world) in self.worlds.iter_mut().enumerate() {
            let episode = first + k as u64;
            world.reset(s.seed, episode);
            self.policy_seeds[k] = policy_seed(s.seed, episode);
            self.eyes[k].begin(s, self.policy_seeds[k]);
        }
        let at = self.steps * self.row();
        self.observe(at);
    }

    /// Writes the present observations to `at`.
    fn observe(&mut self, at: usize) {
        let n = self.uavs;
        for (k, world) in self.worlds.iter().enumerate() {
            let place = at + k * n..at + (k + 1) * n;
            let (o, l) = (self.observations.part_mut(place.clone()), &mut self.links[place]);
            self.eyes[k].observe(world, o, l);
        }
    }

    /// Plays a rollout with sampled actions, values it and computes advantages.
    /// With `advised` the observations are asked for advice too.
    pub fn play(&mut self, s: &Settings, nets: &Networks, norm: &ValueNorm, advised: bool, work: &mut Workspace) {
        self.begin();
        for t in 0..=self.steps {
            self.look(t, nets, norm, work);
            self.go_on(t, s, advised);
        }
    }

    /// Begins a rollout where the last one ended.
    pub fn begin(&mut self) {
        let last = self.steps * self.row();
        self.observations.copy_within(last..last + self.row(), 0);
        self.links.copy_within(last.., 0);
    }

    /// What is seen before step `t`, for an engine.
    ///
    /// # Panics
    /// When it is seen in cells, which engines do not take.
    #[must_use]
    pub fn seen(&self, t: usize) -> GraphBatch<'_> {
        self.seen_at(t * self.row()..(t + 1) * self.row())
    }

    /// What is seen after the rollout, or at the start of an episode.
    ///
    /// # Panics
    /// As [`Self::seen`] does.
    #[must_use]
    pub fn next(&self) -> GraphBatch<'_> {
        self.seen(self.steps)
    }

    /// What was seen before the steps of the rollout, all of them.
    ///
    /// # Panics
    /// As [`Self::seen`] does.
    #[must_use]
    pub fn rollout_batch(&self) -> GraphBatch<'_> {
        self.seen_at(0..self.steps * self.row())
    }

    fn seen_at(&self, place: Range<usize>) -> GraphBatch<'_> {
        let ObservationSlice::Compact(observations) = self.observations.part(place.clone()) else {
            panic!("runs with observations in cells are refused before an engine is asked")
        };
        GraphBatch { uavs: self.uavs, observations, links: &self.links[place] }
    }

    /// Step `t` with the actions taken; after the last one, computes advantages.
    pub fn go_on(&mut self, t: usize, s: &Settings, advised: bool) {
        if t < self.steps {
            if advised {
                self.ask(t);
            }
            self.step(t, s);
            self.observe((t + 1) * self.row());
        } else {
            self.estimate(s);
        }
    }

    /// Values the state before step `t` and, if the rollout has this step, samples its
    /// actions.
    fn look(&mut self, t: usize, nets: &Networks, norm: &ValueNorm, work: &mut Workspace) {
        let (n, row) = (self.uavs, self.row());
        let pass = worlds_in_pass(n, self.worlds.len());
        for first in (0..self.worlds.len()).step_by(pass) {
            let worlds = first..(first + pass).min(self.worlds.len());
            let place = t * row + worlds.start * n..t * row + worlds.end * n;
            work.see(n, self.observations.part(place.clone()), &self.links[place]);
            work.critic.forward(&nets.critic, &work.inputs);
            self.value(t, worlds.clone(), work.critic.values().values(), norm);
            if t < self.steps {
                work.actor.forward(&nets.actor, &work.inputs);
                self.decide(t, worlds, work.actor.logits().values(), &mut work.draws);
            }
        }
    }

    /// As [`Self::play`] does before step `t`, with logits and values of all worlds that were
    /// computed elsewhere, in rows as [`Outputs`](covey_net::Outputs) has them.
    pub fn take(&mut self, t: usize, logits: &[f32], values: &[f32], norm: &ValueNorm, work: &mut Workspace) {
        let all = 0..self.worlds.len();
        self.value(t, all.clone(), values, norm);
        if t < self.steps {
            self.decide(t, all, logits, &mut work.draws);
        }
    }

    /// Takes the critic's rows of some worlds before step `t`.
    fn value(&mut self, t: usize, worlds: Range<usize>, rows: &[f32], norm: &ValueNorm) {
        let place = t * self.row() + worlds.start * self.uavs..t * self.row() + worlds.end * self.uavs;
        let raw = rows.iter().step_by(padded(1));
        self.values[place].iter_mut().zip(raw).for_each(|(v, &raw)| *v = norm.restore(raw));
    }

    /// Samples the actions of some worlds in step `t` from their rows of logits.
    fn decide(&mut self, t: usize, worlds: Range<usize>, rows: &[f32], draws: &mut Vec<f64>) {
        let n = self.uavs;
        let place = t * self.row() + worlds.start * n..t * self.row() + worlds.end * n;
        draws.clear();
        for (world, seed) in self.worlds[worlds.clone()].iter().zip(&self.policy_seeds[worlds]) {
            let draw = |id| action_draw(*seed, id as u16, world.steps_done());
            draws.extend((0..n).map(|id| f64::from(draw(id)) / (1u64 << 32) as f64));
        }
        let taken = &mut self.actions[place.clone()];
        let log_p = &mut self.log_probabilities[place];
        softmax::sample(rows, draws, |k, action, l| {
            taken[k] = action;
            log_p[k] = l;
        });
    }

    /// What the observations before step `t` advise; those in cells advise nothing.
    fn ask(&mut self, t: usize) {
        let (n, first) = (self.uavs, t * self.row());
        let ObservationSlice::Compact(observations) = self.observations.part(first..first + self.row()) else { return };
        for (k, (advised, observation)) in self.advice[first..].iter_mut().zip(observations).enumerate() {
            *advised = advice(observation, self.worlds[k / n].velocity(k % n));
        }
    }

    /// Plays a rollout with uniformly random actions: the environment alone.
    pub fn wander(&mut self, s: &Settings) {
        let row = self.row();
        for t in 0..self.steps {
            for k in 0..row {
                let (world, id) = (k / self.uavs, (k % self.uavs) as u16);
                let draw = u64::from(action_draw(self.policy_seeds[world], id, self.worlds[world].steps_done()));
                let index = ((draw * ACTIONS as u64) >> 32) as u8;
                self.actions[t * row + k] = Action::new(index).unwrap_or(Action::COAST);
            }
            self.step(t, s);
            self.observe((t + 1) * row);
        }
    }

    fn step(&mut self, t: usize, s: &Settings) {
        let (row, n) = (self.row(), self.uavs);
        for (k, world) in self.worlds.iter_mut().enumerate() {
            let place = t * row + k * n..t * row + (k + 1) * n;
            world.step(&self.actions[place.clone()]);
            let rewards = world.rewards();
            let team = rewards.iter().sum::<f32>() / n as f32;
            let (share, cost) = (s.team_share as f32, s.overlap_cost as f32);
            let taken = world.overlaps().iter().zip(world.energy());
            for ((r, own), (&overlap, energy)) in self.rewards[place].iter_mut().zip(rewards).zip(taken) {
                *r = own + share * (team - own) - cost * overlap as f32 / energy;
            }
        }
    }

    fn estimate(&mut self, s: &Settings) {
        let row = self.row();
        let ended = self.worlds.first().is_some_and(World::done);
        let unvalued = ended && (!s.bootstrap_end || s.gamma >= 1.0);
        let (mut r, mut v) = (vec![0.0; self.steps], vec![0.0; self.steps + 1]);
        let mut a = vec![0.0; self.steps];
        for k in 0..row {
            r.iter_mut().enumerate().for_each(|(t, r)| *r = self.rewards[t * row + k]);
            v.iter_mut().enumerate().for_each(|(t, v)| *v = self.values[t * row + k]);
            if unvalued {
                v[self.steps] = 0.0;
            }
            advantages(&r, &v, s.gamma as f32, s.lambda as f32, &mut a);
            for t in 0..self.steps {
                self.advantages[t * row + k] = a[t];
                self.returns[t * row + k] = a[t] + v[t];
            }
        }
    }

    /// Whether its worlds are those of the scenario: others would blur the curves.
    #[must_use]
    pub const fn is_usual(&self, s: &Settings) -> bool {
        self.number.is_multiple_of(2) || s.uavs_max == 0 && s.other_distribution_share == 0.0
    }

    /// Metrics of the episodes in their present state, summed over the worlds.
    #[must_use]
    pub fn metrics(&self) -> Vec<EpisodeMetrics> {
        self.worlds.iter().map(World::metrics).collect()
    }
}
