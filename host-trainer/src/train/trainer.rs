//! A run in memory, and one round of it.

use super::architecture::layouts;
use super::round_metrics::RoundMetrics;
use super::state::State;
use super::update::{UpdatePlan, UpdateSums, update};
use crate::backend::{Backend, Collection, CpuBackend, DeviceBackend};
use crate::optim::{Adam, Learner, PpoLoss, RolloutBatch, update_ema};
use crate::rollout::{RolloutBuffer, RolloutWorker, ValueNorm, VecEnv, Workers, mean_and_deviation};
use crate::settings::Settings;
use covey_env::radio::RadioWorldError;
use covey_env::{EpisodeMetrics, ObservationForm};
use covey_net::{ActorCritic, Engine, EngineError, Inputs, ParameterLayout, initialise};

/// A run in memory.
pub struct Trainer {
    settings: Settings,
    layouts: ActorCritic<ParameterLayout>,
    /// Rounds done.
    rounds: u32,
    learner: Learner,
    /// Exponential moving average of the actor's parameters.
    average: Vec<f32>,
    value_norm: ValueNorm,
    rollout_workers: Vec<RolloutWorker>,
    backend: Box<dyn Backend>,
}

impl Trainer {
    /// A fresh run.
    ///
    /// # Errors
    /// When the scenario or the radio model cannot be built.
    pub fn new(settings: Settings) -> Result<Self, RadioWorldError> {
        let inputs = settings.observation.len() as u16;
        Self::with_inputs(settings, inputs)
    }

    /// A fresh run of networks that take only the first `inputs` numbers of a compact observation:
    /// for comparisons; what they learn cannot be exported.
    ///
    /// # Errors
    /// When the scenario or the radio model cannot be built.
    pub fn with_inputs(settings: Settings, inputs: u16) -> Result<Self, RadioWorldError> {
        let layouts = layouts(&settings, inputs);
        let actor = initialise(&layouts.actor, "actor weights", settings.seed);
        let state = State {
            rounds: 0,
            average: actor.clone(),
            actor,
            critic: initialise(&layouts.critic, "critic weights", settings.seed),
            actor_adam: Adam::new(layouts.actor.len()),
            critic_adam: Adam::new(layouts.critic.len()),
            norm: ValueNorm::default(),
        };
        Self::assemble(settings, state, inputs)
    }

    /// A run that goes on from `state`, which must be of these settings.
    ///
    /// # Errors
    /// When the scenario or the radio model cannot be built.
    pub fn resume(settings: Settings, state: State) -> Result<Self, RadioWorldError> {
        let inputs = settings.observation.len() as u16;
        Self::assemble(settings, state, inputs)
    }

    fn assemble(settings: Settings, state: State, inputs: u16) -> Result<Self, RadioWorldError> {
        let (num_envs, shards) = (settings.num_envs as usize, settings.shards as usize);
        let rollout_workers = (0..shards)
            .map(|k| RolloutWorker::new(&settings, k as u32, (k + 1) * num_envs / shards - k * num_envs / shards))
            .collect::<Result<_, _>>()?;
        let layouts = layouts(&settings, inputs);
        let parameters = ActorCritic { actor: state.actor, critic: state.critic };
        let optimisers = ActorCritic { actor: state.actor_adam, critic: state.critic_adam };
        let inputs = match settings.observation {
            ObservationForm::Compact => Inputs::new(inputs.into()),
            ObservationForm::Cells => Inputs::of(ObservationForm::Cells),
        };
        Ok(Self {
            rounds: state.rounds,
            learner: Learner::new(&layouts, settings.graph, parameters, optimisers),
            average: state.average,
            value_norm: state.norm,
            rollout_workers,
            backend: Box::new(CpuBackend::new(&layouts, &inputs, shards)),
            layouts,
            settings,
        })
    }

    /// The run with its networks computed by a device, which must be for its layouts.
    ///
    /// # Errors
    /// When devices do not take such settings, the device fails, or its numbers are not those of
    /// the networks on the CPU.
    pub fn on(mut self, engine: Box<dyn Engine>) -> Result<Self, EngineError> {
        let s = &self.settings;
        // Something to compare the numbers with.
        self.rollout_workers[0].reset(s, 0, s.uavs);
        let backend = DeviceBackend::new(engine, s, &self.layouts, &self.learner, &self.rollout_workers[0])?;
        self.backend = Box::new(backend);
        Ok(self)
    }

    /// What computes the networks.
    #[must_use]
    pub fn device(&self) -> String {
        self.backend.name()
    }

    /// Parameter layouts of its networks.
    #[must_use]
    pub const fn layouts(&self) -> &ActorCritic<ParameterLayout> {
        &self.layouts
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Rounds done.
    #[must_use]
    pub const fn rounds(&self) -> u32 {
        self.rounds
    }

    /// Whether all rounds are done.
    #[must_use]
    pub fn done(&self) -> bool {
        self.rounds >= self.settings.rounds()
    }

    /// A copy of the state after the rounds so far, for a checkpoint.
    #[must_use]
    pub fn state(&self) -> State {
        let Learner { actor, critic } = &self.learner;
        State {
            rounds: self.rounds,
            actor: actor.parameters.clone(),
            average: self.average.clone(),
            critic: critic.parameters.clone(),
            actor_adam: actor.optimiser.clone(),
            critic_adam: critic.optimiser.clone(),
            norm: self.value_norm,
        }
    }

    /// Plays an episode in every world, with an update after every rollout.
    ///
    /// # Errors
    /// When a device fails, never on the CPU. The round is then half done: go on from a
    /// checkpoint.
    pub fn round(&mut self, threads: &Workers) -> Result<RoundMetrics, EngineError> {
        self.reset(threads);
        let rollouts = self.rollouts_in_round();
        let updates_in_run = f64::from(self.settings.rounds()) * f64::from(rollouts);
        let (mut sums, mut explained_variance, mut learning_rate) = (UpdateSums::default(), 0.0, 0.0);
        for rollout in 0..rollouts {
            let number = u64::from(self.rounds) * u64::from(rollouts) + u64::from(rollout);
            let plan = self.update_plan(number, number as f64 / updates_in_run);
            self.collect(self.settings.cloning_weight_at(number) > 0.0, threads)?;
            explained_variance += self.explained_variance() / f64::from(rollouts);
            learning_rate = plan.learning_rate;
            sums.add(&self.update(&plan, threads)?);
        }
        self.rounds += 1;
        Ok(self.metrics(&sums, explained_variance, learning_rate))
    }

    /// Rollouts, and so updates, in a round.
    pub(super) const fn rollouts_in_round(&self) -> u32 {
        self.settings.steps / self.settings.rollout_steps
    }

    /// Begins the episodes of the present round.
    fn reset(&mut self, threads: &Workers) {
        let (s, round) = (&self.settings, self.rounds);
        let mut next = u64::from(round) * u64::from(s.num_envs);
        let items = self.rollout_workers.iter_mut().map(|worker| {
            let first_episode = next;
            next += worker.env().num_envs() as u64;
            (worker, first_episode)
        });
        threads.run(items.collect(), |k, (worker, first_episode): (&mut RolloutWorker, _)| {
            worker.reset(s, first_episode, s.uavs_in(round, k as u32));
        });
    }

    /// Begins episodes of the configured number of UAVs in all worlds, the same every time.
    pub(super) fn reset_to_equal_swarms(&mut self, threads: &Workers) {
        let s = &self.settings;
        threads.run(self.rollout_workers.iter_mut().collect(), |k, worker| worker.reset(s, k as u64, s.uavs));
    }

    /// Collects a rollout in every world; with `cloning`, the expert's actions too.
    pub(super) fn collect(&mut self, cloning: bool, threads: &Workers) -> Result<(), EngineError> {
        let collection = Collection { settings: &self.settings, value_norm: self.value_norm, cloning };
        self.backend.collect(&self.learner, &collection, &mut self.rollout_workers, threads)
    }

    /// A rollout of random actions in every world.
    pub(super) fn random_rollouts(&mut self, threads: &Workers) {
        let s = &self.settings;
        threads.run(self.rollout_workers.iter_mut().collect(), |_, worker| worker.random_rollout(s));
    }

    /// Plan of update `number` of the run, when the share `progress` of the run is done: learning
    /// rate and entropy weight fall linearly with it.
    pub(super) fn update_plan(&self, number: u64, progress: f64) -> UpdatePlan {
        let s = &self.settings;
        UpdatePlan {
            number,
            seed: s.seed,
            epochs: s.epochs,
            minibatch: s.minibatch as usize,
            learning_rate: s.learning_rate * (1.0 - (1.0 - s.learning_rate_end) * progress),
            max_gradient_norm: s.gradient_norm,
            loss: PpoLoss {
                clip_range: s.clip as f32,
                entropy_coef: (s.entropy + (s.entropy_end - s.entropy) * progress) as f32,
                huber_delta: s.huber as f32,
                cloning_weight: s.cloning_weight_at(number) as f32,
            },
        }
    }

    /// Updates value normalisation, networks and the actor's average from the last rollouts.
    pub(super) fn update(&mut self, plan: &UpdatePlan, threads: &Workers) -> Result<UpdateSums, EngineError> {
        let (mean, deviation) = mean_and_deviation(&self.all(|buffer| &buffer.returns));
        self.value_norm.update(mean, deviation, self.settings.value_norm_decay);
        let rollout = RolloutBatch::new(&self.rollout_workers, self.value_norm);
        let sums = update(&mut self.learner, &mut *self.backend, &rollout, plan, threads)?;
        update_ema(&mut self.average, &self.learner.actor.parameters, self.settings.ema_decay, plan.number);
        Ok(sums)
    }

    pub(super) fn backend_mut(&mut self) -> &mut dyn Backend {
        &mut *self.backend
    }

    /// A tensor of all workers' buffers in one.
    fn all(&self, tensor: fn(&RolloutBuffer) -> &Vec<f32>) -> Vec<f32> {
        self.rollout_workers.iter().flat_map(|worker| tensor(worker.buffer())).copied().collect()
    }

    /// 1 − var(return − value)/var(return); return − value is the advantage.
    fn explained_variance(&self) -> f64 {
        let (_, of_returns) = mean_and_deviation(&self.all(|buffer| &buffer.returns));
        let (_, of_errors) = mean_and_deviation(&self.all(|buffer| &buffer.advantages));
        if of_returns > 0.0 { 1.0 - (of_errors / of_returns).powi(2) } else { 0.0 }
    }

    fn metrics(&self, sums: &UpdateSums, explained_variance: f64, learning_rate: f64) -> RoundMetrics {
        let s = &self.settings;
        let configured =
            self.rollout_workers.iter().map(RolloutWorker::env).filter(|env| env.is_configured_scenario(s));
        let all: Vec<EpisodeMetrics> = configured.flat_map(VecEnv::metrics).collect();
        let mean = |f: fn(&EpisodeMetrics) -> f64| all.iter().map(f).sum::<f64>() / all.len() as f64;
        let per_sample = |v: f64| v / sums.losses.samples;
        RoundMetrics {
            episodes: u64::from(self.rounds) * u64::from(s.num_envs),
            agent_steps: s.agent_steps(self.rounds),
            coverage: mean(|m| m.coverage),
            coverage_last: mean(|m| m.coverage_last),
            energy: mean(|m| m.energy),
            individual: mean(|m| m.individual),
            group: mean(|m| m.group),
            reward: mean(|m| m.reward),
            policy_loss: per_sample(sums.losses.policy_loss),
            value_loss: per_sample(sums.losses.value_loss),
            entropy: per_sample(sums.losses.entropy),
            kl: per_sample(sums.losses.kl),
            clip_fraction: per_sample(sums.losses.clipped),
            actor_gradient: sums.gradient_norms.actor / sums.minibatches,
            critic_gradient: sums.gradient_norms.critic / sums.minibatches,
            explained_variance,
            learning_rate,
        }
    }
}
