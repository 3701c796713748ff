//! The state of a training run and one round of it.

use super::adam::Adam;
use super::advantage::{ValueNorm, moments};
use super::engine::OnEngine;
use super::networks::{Networks, Workspace};
use super::ppo::Loss;
use super::shard::Shard;
use super::update::{Learner, Outcome, Plan, Rollout, update};
use super::workers::Workers;
use crate::settings::Settings;
use covey_env::radio::RadioWorldError;
use covey_env::{EpisodeMetrics, ObservationForm};
use covey_net::{Engine, EngineError, Inputs, ParameterLayout, initialise};
use covey_report::metrics::nan_as_null;
use firmware_core::action::ACTIONS;
use firmware_core::actor::Dimensions;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// All that a run carries from round to round. Random numbers are drawn from streams
/// named by the seed and the round, so no generator's state is part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Rounds done.
    pub rounds: u32,
    /// The actor's parameters.
    pub actor: Vec<f32>,
    /// Their running average: what is exported.
    pub average: Vec<f32>,
    /// The critic's parameters.
    pub critic: Vec<f32>,
    /// The actor's optimiser.
    pub actor_adam: Adam,
    /// The critic's optimiser.
    pub critic_adam: Adam,
    /// Normalisation of returns.
    pub norm: ValueNorm,
}

/// What a round gave: one row of `metrics.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Episodes played so far.
    pub episodes: u64,
    /// Agent-steps so far.
    pub agent_steps: u64,
    /// Coverage index, mean over steps and the round's episodes.
    #[serde(with = "nan_as_null")]
    pub coverage: f64,
    /// Coverage after the last step.
    #[serde(with = "nan_as_null")]
    pub coverage_last: f64,
    /// Energy index.
    #[serde(with = "nan_as_null")]
    pub energy: f64,
    /// PoIs a UAV alone covers in its group.
    #[serde(with = "nan_as_null")]
    pub individual: f64,
    /// PoIs its group covers.
    #[serde(with = "nan_as_null")]
    pub group: f64,
    /// Episodic reward.
    #[serde(with = "nan_as_null")]
    pub reward: f64,
    /// Clipped surrogate, negated.
    #[serde(with = "nan_as_null")]
    pub policy_loss: f64,
    /// Value loss (of normalised returns).
    #[serde(with = "nan_as_null")]
    pub value_loss: f64,
    /// Entropy of the policy, nats.
    #[serde(with = "nan_as_null")]
    pub entropy: f64,
    /// Estimated KL divergence between the policies before and within an update, nats.
    #[serde(with = "nan_as_null")]
    pub kl: f64,
    /// Share of samples whose ratio left the clip range.
    #[serde(with = "nan_as_null")]
    pub clip_fraction: f64,
    /// Norm of the actor's gradient before clipping.
    #[serde(with = "nan_as_null")]
    pub actor_gradient: f64,
    /// Norm of the critic's gradient before clipping.
    #[serde(with = "nan_as_null")]
    pub critic_gradient: f64,
    /// Share of the variance of returns that the values explain.
    #[serde(with = "nan_as_null")]
    pub explained_variance: f64,
    /// Learning rate.
    #[serde(with = "nan_as_null")]
    pub learning_rate: f64,
}

/// Title, label of the value axis, metric of the same name in evaluations, and value.
type ChartOf = (&'static str, &'static str, &'static str, fn(&Row) -> f64);

impl Row {
    /// The curves of the paper's figures 5 to 10, then those that tell how learning goes.
    pub const CHARTS: &[ChartOf] = &[
        ("Episodic reward", "reward", "reward", |r| r.reward),
        ("Coverage index", "share of PoIs", "coverage", |r| r.coverage),
        ("Energy index", "0.5 hovering, 1 full speed", "energy", |r| r.energy),
        ("Policy loss", "clipped surrogate", "", |r| r.policy_loss),
        ("Individual covered PoIs", "PoIs a UAV", "individual", |r| r.individual),
        ("Group covered PoIs", "PoIs a group", "group", |r| r.group),
        ("Coverage, last step", "share of PoIs", "coverage_last", |r| r.coverage_last),
        ("Entropy of the policy", "nats", "", |r| r.entropy),
        ("Value loss", "of normalised returns", "", |r| r.value_loss),
        ("Explained variance", "of returns", "", |r| r.explained_variance),
        ("KL divergence", "nats", "", |r| r.kl),
        ("Clip fraction", "share of samples", "", |r| r.clip_fraction),
        ("Learning rate", "", "", |r| r.learning_rate),
    ];

    /// Tags and values for TensorBoard.
    #[must_use]
    pub fn curves(&self) -> [(&'static str, f64); 15] {
        [
            ("episode/reward", self.reward),
            ("episode/coverage", self.coverage),
            ("episode/coverage_last", self.coverage_last),
            ("episode/energy", self.energy),
            ("episode/individual", self.individual),
            ("episode/group", self.group),
            ("loss/policy", self.policy_loss),
            ("loss/value", self.value_loss),
            ("loss/entropy", self.entropy),
            ("learning/kl", self.kl),
            ("learning/clip_fraction", self.clip_fraction),
            ("learning/actor_gradient", self.actor_gradient),
            ("learning/critic_gradient", self.critic_gradient),
            ("learning/explained_variance", self.explained_variance),
            ("learning/learning_rate", self.learning_rate),
        ]
    }
}

/// A part of training that can be timed alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The environment with observations, and random actions.
    Environment,
    /// Rollout: environment, actor, sampling, critic, advantages.
    Policy,
    /// The update on a rollout that was played before.
    Update,
}

/// A run in memory.
pub struct Trainer {
    settings: Settings,
    layouts: [ParameterLayout; 2],
    state: State,
    shards: Vec<Shard>,
    nets: Networks,
    work: Vec<Workspace>,
    engine: Option<OnEngine>,
}

impl Trainer {
    /// A fresh run.
    ///
    /// # Errors
    /// When the scenario or the link cannot be built.
    pub fn new(settings: Settings) -> Result<Self, RadioWorldError> {
        let inputs = settings.observation.len() as u16;
        Self::with_inputs(settings, inputs)
    }

    /// A fresh run of networks that take only the first `inputs` numbers of a compact observation:
    /// for comparisons; what they learn cannot be exported.
    ///
    /// # Errors
    /// When the scenario or the link cannot be built.
    pub fn with_inputs(settings: Settings, inputs: u16) -> Result<Self, RadioWorldError> {
        let layouts = layouts(&settings, inputs);
        let actor = initialise(&layouts[0], "actor weights", settings.seed);
        let state = State {
            rounds: 0,
            average: actor.clone(),
            actor,
            critic: initialise(&layouts[1], "critic weights", settings.seed),
            actor_adam: Adam::new(layouts[0].len()),
            critic_adam: Adam::new(layouts[1].len()),
            norm: ValueNorm::default(),
        };
        Self::assemble(settings, state, inputs)
    }

    /// A run that goes on from `state`, which must be of these settings.
    ///
    /// # Errors
    /// When the scenario or the link cannot be built.
    pub fn resume(settings: Settings, state: State) -> Result<Self, RadioWorldError> {
        let inputs = settings.observation.len() as u16;
        Self::assemble(settings, state, inputs)
    }

    fn assemble(settings: Settings, state: State, inputs: u16) -> Result<Self, RadioWorldError> {
        let (worlds, shards) = (settings.num_envs as usize, settings.shards as usize);
        let shards: Vec<_> = (0..shards)
            .map(|k| Shard::new(&settings, k as u32, (k + 1) * worlds / shards - k * worlds / shards))
            .collect::<Result<_, _>>()?;
        let layouts = layouts(&settings, inputs);
        let mut nets = Networks::new(&layouts, settings.graph);
        nets.actor.load(&state.actor);
        nets.critic.load(&state.critic);
        let seen = match settings.observation {
            ObservationForm::Compact => Inputs::new(inputs.into()),
            ObservationForm::Cells => Inputs::of(ObservationForm::Cells),
        };
        let work = shards.iter().map(|_| Workspace::new(&layouts, seen.clone())).collect();
        Ok(Self { settings, layouts, state, shards, nets, work, engine: None })
    }

    /// The run with its networks computed by `engine`, which must be for its layouts.
    ///
    /// # Errors
    /// When engines do not take such settings, the engine fails, or its numbers are not those of
    /// the networks by hand.
    pub fn on(mut self, engine: Box<dyn Engine>) -> Result<Self, EngineError> {
        let s = &self.settings;
        let mut engine = OnEngine::new(engine, s)?;
        self.shards[0].reset(s, 0, s.uavs);
        engine.load([&self.state.actor, &self.state.critic]);
        engine.check(self.shards[0].next(), &self.nets, &self.state, &mut self.work[0])?;
        self.engine = Some(engine);
        Ok(self)
    }

    /// What computes the networks.
    #[must_use]
    pub fn device(&self) -> String {
        self.engine.as_ref().map_or_else(|| "cpu".to_owned(), OnEngine::name)
    }

    /// Layouts of actor and critic.
    #[must_use]
    pub fn layouts(s: &Settings) -> [ParameterLayout; 2] {
        layouts(s, s.observation.len() as u16)
    }

    /// Layouts of its networks, which differ from [`Self::layouts`] when they take fewer inputs.
    #[must_use]
    pub fn network_layouts(&self) -> [ParameterLayout; 2] {
        self.layouts.clone()
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The state after the rounds so far.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// Whether all rounds are done.
    #[must_use]
    pub fn done(&self) -> bool {
        self.state.rounds >= self.settings.rounds()
    }

    /// Plays an episode in every world, with an update after every rollout.
    ///
    /// # Errors
    /// When an engine fails, never without one. The round is then half done: go on from a
    /// checkpoint.
    pub fn round(&mut self, workers: &Workers) -> Result<Row, EngineError> {
        let s = self.settings.clone();
        let mut first = u64::from(self.state.rounds) * u64::from(s.num_envs);
        let firsts: Vec<u64> = self
            .shards
            .iter()
            .map(|shard| {
                let own = first;
                first += shard.worlds() as u64;
                own
            })
            .collect();
        let round = self.state.rounds;
        let work: Vec<_> = self.shards.iter_mut().zip(firsts).collect();
        workers.run(work, |k, (shard, first)| shard.reset(&s, first, s.uavs_in(round, k as u32)));
        let rollouts = s.steps / s.rollout_steps;
        let (mut total, mut explained, mut rate) = (Outcome::default(), 0.0, 0.0);
        for rollout in 0..rollouts {
            let number = u64::from(self.state.rounds) * u64::from(rollouts) + u64::from(rollout);
            self.play(&s, s.cloning_weight_at(number) > 0.0, workers)?;
            explained += self.explained_variance() / f64::from(rollouts);
            let progress = number as f64 / (f64::from(s.rounds()) * f64::from(rollouts));
            rate = s.learning_rate * (1.0 - (1.0 - s.learning_rate_end) * progress);
            let outcome = self.learn(&s, workers, number, progress, rate)?;
            total.sums.add(&outcome.sums);
            total.minibatches += outcome.minibatches;
            total.norms.iter_mut().zip(outcome.norms).for_each(|(t, o)| *t += o);
        }
        self.state.rounds += 1;
        Ok(self.row(&total, explained, rate))
    }

    /// Time of an episode's worth of one stage in every world. The state of the run
    /// moves on as in training, except that [`Stage::Environment`] learns nothing.
    ///
    /// # Errors
    /// When an engine fails.
    pub fn time(&mut self, stage: Stage, workers: &Workers) -> Result<Duration, EngineError> {
        let s = self.settings.clone();
        workers.run(self.shards.iter_mut().collect(), |k, shard| shard.reset(&s, k as u64, s.uavs));
        let mut spent = Duration::ZERO;
        for rollout in 0..s.steps / s.rollout_steps {
            let start = Instant::now();
            match stage {
                Stage::Environment => {
                    workers.run(self.shards.iter_mut().collect(), |_, shard| shard.wander(&s));
                }
                Stage::Policy | Stage::Update => self.play(&s, false, workers)?,
            }
            let played = start.elapsed();
            let start = Instant::now();
            if stage == Stage::Update {
                self.learn(&s, workers, u64::from(rollout), 0.0, s.learning_rate)?;
            }
            spent += if stage == Stage::Update { start.elapsed() } else { played };
        }
        Ok(spent)
    }

    /// Multiply-adds that the update of an episode's worth in every world takes, those with
    /// a zero left out; none that an engine does. It learns as [`Self::time`] does.
    ///
    /// # Errors
    /// When an engine fails.
    pub fn count_update(&mut self, workers: &Workers) -> Result<u64, EngineError> {
        self.work.iter_mut().for_each(|w| w.counted = Some(0));
        self.time(Stage::Update, workers)?;
        Ok(self.work.iter_mut().filter_map(|w| w.counted.take()).sum())
    }

    /// Plays a rollout in every world, with or without advice.
    fn play(&mut self, s: &Settings, advised: bool, workers: &Workers) -> Result<(), EngineError> {
        let (nets, norm) = (&self.nets, self.state.norm);
        if let Some(engine) = &mut self.engine {
            return engine.play(s, &norm, advised, &mut self.shards, &mut self.work, workers);
        }
        let items = self.shards.iter_mut().zip(&mut self.work).collect();
        workers.run(items, |_, (shard, work): (&mut Shard, &mut Workspace)| shard.play(s, nets, &norm, advised, work));
        Ok(())
    }

    fn learn(
        &mut self,
        s: &Settings,
        workers: &Workers,
        number: u64,
        progress: f64,
        learning_rate: f64,
    ) -> Result<Outcome, EngineError> {
        let all = |f: fn(&Shard) -> &Vec<f32>| self.shards.iter().flat_map(f).copied().collect::<Vec<f32>>();
        let (mean, deviation) = moments(&all(|s| &s.returns));
        self.state.norm.update(mean, deviation, s.value_norm_decay);
        let rollout = Rollout {
            advantage: moments(&all(|s| &s.advantages)),
            shards: &self.shards,
            steps: s.rollout_steps as usize,
            norm: self.state.norm,
        };
        let plan = Plan {
            epochs: s.epochs,
            minibatch: s.minibatch as usize,
            learning_rate,
            gradient_norm: s.gradient_norm,
            loss: Loss {
                clip: s.clip as f32,
                entropy: (s.entropy + (s.entropy_end - s.entropy) * progress) as f32,
                huber: s.huber as f32,
                cloning_weight: s.cloning_weight_at(number) as f32,
                samples: 1.0,
            },
            shuffle: (s.seed, number),
        };
        let state = &mut self.state;
        let mut learner = Learner {
            nets: &mut self.nets,
            values: [&mut state.actor, &mut state.critic],
            adam: [&mut state.actor_adam, &mut state.critic_adam],
            work: if self.engine.is_some() { &mut self.work[..1] } else { &mut self.work },
            engine: self.engine.as_mut(),
        };
        let outcome = update(&mut learner, &rollout, &plan, workers)?;
        // Early on the average is over all updates so far, or the first weights would linger.
        let keep = s.ema_decay.min(number as f64 / (number as f64 + 1.0)) as f32;
        for (average, value) in state.average.iter_mut().zip(&state.actor) {
            *average = keep * *average + (1.0 - keep) * value;
        }
        Ok(outcome)
    }

    /// 1 − var(return − value)/var(return); return − value is the advantage.
    fn explained_variance(&self) -> f64 {
        let all = |f: fn(&Shard) -> &Vec<f32>| self.shards.iter().flat_map(f).copied().collect::<Vec<f32>>();
        let (_, of_returns) = moments(&all(|s| &s.returns));
        let (_, of_errors) = moments(&all(|s| &s.advantages));
        if of_returns > 0.0 { 1.0 - (of_errors / of_returns).powi(2) } else { 0.0 }
    }

    fn row(&self, o: &Outcome, explained_variance: f64, learning_rate: f64) -> Row {
        let s = &self.settings;
        let usual = self.shards.iter().filter(|shard| shard.is_usual(s));
        let all: Vec<EpisodeMetrics> = usual.flat_map(Shard::metrics).collect();
        let mean = |f: fn(&EpisodeMetrics) -> f64| all.iter().map(f).sum::<f64>() / all.len() as f64;
        let episodes = u64::from(self.state.rounds) * u64::from(s.num_envs);
        let of = |v: f64| v / o.sums.samples;
        Row {
            episodes,
            agent_steps: s.agent_steps(self.state.rounds),
            coverage: mean(|m| m.coverage),
            coverage_last: mean(|m| m.coverage_last),
            energy: mean(|m| m.energy),
            individual: mean(|m| m.individual),
            group: mean(|m| m.group),
            reward: mean(|m| m.reward),
            policy_loss: of(o.sums.policy_loss),
            value_loss: of(o.sums.value_loss),
            entropy: of(o.sums.entropy),
            kl: of(o.sums.kl),
            clip_fraction: of(o.sums.clipped),
            actor_gradient: o.norms[0] / o.minibatches,
            critic_gradient: o.norms[1] / o.minibatches,
            explained_variance,
            learning_rate,
        }
    }
}

/// Widths of the networks for these settings.
#[must_use]
pub fn dimensions(s: &Settings) -> Dimensions {
    Dimensions {
        observation: s.observation.len() as u16,
        hidden: s.hidden,
        feature: s.feature,
        head: s.head,
        actions: ACTIONS as u16,
    }
}

fn layouts(s: &Settings, inputs: u16) -> [ParameterLayout; 2] {
    let d = Dimensions { observation: inputs, ..dimensions(s) };
    [ParameterLayout::actor(d, s.graph), ParameterLayout::critic(d)]
}
