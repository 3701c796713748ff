//! Playing and learning with networks that an [`Engine`] computes: all worlds of a step at
//! once, whole minibatches at once. Worlds, sampling, loss and optimiser stay here.

use super::advantage::ValueNorm;
use super::networks::{Networks, Workspace};
use super::ppo::{Loss, Sums};
use super::shard::Shard;
use super::trainer::State;
use super::update::{Place, Rollout};
use super::workers::Workers;
use crate::settings::Settings;
use covey_env::ObservationForm;
use covey_net::{Engine, EngineError, GraphBatch, Outputs, Rows};

/// Most that an engine's numbers may be off, of the greatest: GPUs may multiply with fewer
/// digits, a wrong kernel is off by all.
const TOLERANCE: f32 = 0.02;

/// An engine with its buffers.
pub struct OnEngine {
    engine: Box<dyn Engine>,
    out: Outputs,
    /// First world-step of each shard among the held ones.
    firsts: Vec<u32>,
}

impl OnEngine {
    /// With empty buffers, for a run with these settings.
    ///
    /// # Errors
    /// When engines do not take such a run.
    pub fn new(engine: Box<dyn Engine>, s: &Settings) -> Result<Self, EngineError> {
        let only = [
            (s.observation == ObservationForm::Compact, "observation = \"compact\""),
            (s.uavs_max == 0, "uavs_max = 0"),
        ];
        if let Some((_, setting)) = only.into_iter().find(|(met, _)| !met) {
            return Err(EngineError::Unsupported { device: engine.name(), setting });
        }
        Ok(Self { engine, out: Outputs::default(), firsts: Vec::new() })
    }

    /// What it computes on.
    pub fn name(&self) -> String {
        self.engine.name()
    }

    /// Gives it the parameters of actor and critic.
    pub fn load(&mut self, parameters: [&[f32]; 2]) {
        self.engine.load(parameters);
    }

    /// Plays a rollout in all shards, step by step.
    pub fn play(
        &mut self,
        s: &Settings,
        norm: &ValueNorm,
        advised: bool,
        shards: &mut [Shard],
        work: &mut [Workspace],
        workers: &Workers,
    ) -> Result<(), EngineError> {
        shards.iter_mut().for_each(Shard::begin);
        for t in 0..=s.rollout_steps as usize {
            let seen: Vec<GraphBatch<'_>> = shards.iter().map(|s| s.seen(t)).collect();
            self.engine.forward(&seen, &mut self.out)?;
            let (mut logits, mut values) = (parts(&self.out.logits), parts(&self.out.values));
            let items = shards.iter_mut().zip(&mut *work);
            let items = items.map(|(shard, work)| {
                let rows = shard.row();
                (logits(rows), values(rows), shard, work)
            });
            workers.run(items.collect(), |_, (logits, values, shard, work): (_, _, &mut Shard, &mut Workspace)| {
                shard.take(t, logits, values, norm, work);
                shard.go_on(t, s, advised);
            });
        }
        Ok(())
    }

    /// Takes the observations of a rollout, which [`Self::gradient`] is about.
    pub fn hold(&mut self, rollout: &Rollout<'_>) {
        let seen: Vec<GraphBatch<'_>> = rollout.shards.iter().map(Shard::rollout_batch).collect();
        self.engine.hold(&seen);
        let mut first = 0;
        self.firsts.clear();
        for s in &seen {
            self.firsts.push(first);
            first += (s.links.len() / s.uavs) as u32;
        }
    }

    /// Loss of a minibatch, and its gradient in `work.gradients`.
    pub fn gradient(
        &mut self,
        rollout: &Rollout<'_>,
        loss: &Loss,
        batch: &[Place],
        work: &mut Workspace,
    ) -> Result<Sums, EngineError> {
        let number = |p: &Place| self.firsts[p.shard as usize] + p.first / p.uavs;
        let world_steps: Vec<u32> = batch.iter().map(number).collect();
        work.samples.clear();
        work.samples.extend(batch.iter().flat_map(|p| rollout.samples(p)));
        let mut sums = Sums::default();
        let mut backward =
            |out: &mut Outputs| loss.backward(&mut out.logits, &mut out.values, &work.samples, &mut sums);
        self.engine.gradient(&world_steps, &mut self.out, &mut backward, &mut work.gradients)?;
        Ok(sums)
    }

    /// Compares its outputs and gradients with those of the networks by hand: a device whose
    /// driver computes something else must not train.
    pub fn check(
        &mut self,
        seen: GraphBatch<'_>,
        nets: &Networks,
        state: &State,
        work: &mut Workspace,
    ) -> Result<(), EngineError> {
        work.see(seen.uavs, seen.observations.into(), seen.links);
        work.actor.forward(&nets.actor, &work.inputs);
        work.critic.forward(&nets.critic, &work.inputs);
        let by_hand = Outputs { logits: work.actor.logits().clone(), values: work.critic.values().clone() };
        work.sums.0.clear();
        work.sums.1.clear();
        weigh(work.actor.logits_mut());
        weigh(work.critic.values_mut());
        work.actor.backward(&nets.actor, &work.inputs, &mut work.sums.0);
        work.critic.backward(&nets.critic, &work.inputs, &mut work.sums.1);
        let mut gradients = work.gradients.clone();
        work.sums.0.store(&state.actor, &mut gradients[0]);
        work.sums.1.store(&mut gradients[1]);

        self.engine.forward(&[seen], &mut self.out)?;
        self.compare("logits", self.out.logits.values(), by_hand.logits.values())?;
        self.compare("values", self.out.values.values(), by_hand.values.values())?;
        self.engine.hold(&[seen]);
        let all: Vec<u32> = (0..(seen.links.len() / seen.uavs) as u32).collect();
        let mut weighted = |out: &mut Outputs| {
            weigh(&mut out.logits);
            weigh(&mut out.values);
        };
        self.engine.gradient(&all, &mut self.out, &mut weighted, &mut work.gradients)?;
        self.compare("the actor's gradient", &work.gradients[0], &gradients[0])?;
        self.compare("the critic's gradient", &work.gradients[1], &gradients[1])
    }

    fn compare(&self, what: &'static str, got: &[f32], by_hand: &[f32]) -> Result<(), EngineError> {
        let greatest = by_hand.iter().fold(f32::MIN_POSITIVE, |m, v| m.max(v.abs()));
        let off = got.iter().zip(by_hand).map(|(g, h)| (g - h).abs()).fold(0.0, |m: f32, d| if d <= m { m } else { d });
        let error = if got.len() == by_hand.len() { off / greatest } else { f32::INFINITY };
        if error <= TOLERANCE { Ok(()) } else { Err(EngineError::Wrong { device: self.name(), what, error }) }
    }
}

/// Cuts rows off the front, with their padding.
fn parts<'r>(rows: &'r Rows) -> impl FnMut(usize) -> &'r [f32] {
    let (mut rest, step) = (rows.values(), rows.step());
    move |count| {
        let (part, behind) = rest.split_at(count * step);
        rest = behind;
        part
    }
}

/// Overwrites rows by a gradient with all kinds of numbers in it.
fn weigh(rows: &mut Rows) {
    let (step, width) = (rows.step(), rows.width());
    for (r, row) in rows.values_mut().chunks_exact_mut(step).enumerate() {
        row[..width].iter_mut().enumerate().for_each(|(c, v)| *v = ((7 * r + 5 * c) % 11) as f32 - 5.0);
        row[width..].fill(0.0);
    }
}
