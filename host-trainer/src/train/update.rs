//! The update: several passes over a rollout in minibatches, each split into parts
//! whose gradients are summed in a fixed order.

use super::adam::Adam;
use super::advantage::ValueNorm;
use super::engine::OnEngine;
use super::networks::{Networks, Workspace};
use super::ppo::{Loss, Sample, Sums};
use super::shard::Shard;
use super::workers::Workers;
use covey_env::random::{below, stream};
use covey_net::{ActorNet, CriticNet, EngineError, worlds_in_pass};

/// A world-step of the rollout.
#[derive(Clone, Copy)]
pub struct Place {
    /// UAVs in that world.
    pub uavs: u32,
    /// Its shard.
    pub shard: u32,
    /// Index of its first UAV in the shard's arrays.
    pub first: u32,
}

/// What an update needs besides the networks.
pub struct Rollout<'s> {
    /// The shards, played.
    pub shards: &'s [Shard],
    /// Steps in the rollout.
    pub steps: usize,
    /// Mean and deviation of the advantages.
    pub advantage: (f64, f64),
    /// Normalisation of returns.
    pub norm: ValueNorm,
}

impl Rollout<'_> {
    /// The samples of a world-step.
    pub fn samples(&self, p: &Place) -> impl Iterator<Item = Sample> {
        let (s, at) = (&self.shards[p.shard as usize], p.first as usize);
        (at..at + p.uavs as usize).map(|at| self.sample(s, at))
    }

    /// The sample at place `at` of a shard.
    fn sample(&self, s: &Shard, at: usize) -> Sample {
        let (mean, deviation) = self.advantage;
        Sample {
            action: s.actions[at].index(),
            advice: s.advice[at].index(),
            log_probability: s.log_probabilities[at],
            advantage: ((f64::from(s.advantages[at]) - mean) / (deviation + 1e-8)) as f32,
            target: self.norm.normalise(s.returns[at]),
        }
    }
}

/// Both networks with their optimisers.
pub struct Learner<'l> {
    /// As products read them.
    pub nets: &'l mut Networks,
    /// The parameters of actor and critic.
    pub values: [&'l mut Vec<f32>; 2],
    /// Their optimisers.
    pub adam: [&'l mut Adam; 2],
    /// Buffers, one a part of a minibatch.
    pub work: &'l mut [Workspace],
    /// What computes the gradients instead of the networks by hand; then there is one part.
    pub engine: Option<&'l mut OnEngine>,
}

/// How to update.
pub struct Plan {
    /// Passes.
    pub epochs: u32,
    /// Agent samples in a minibatch.
    pub minibatch: usize,
    /// Learning rate.
    pub learning_rate: f64,
    /// Greatest norm of each network's gradient.
    pub gradient_norm: f64,
    /// Clip range, entropy weight, Huber limit (`samples` is set here).
    pub loss: Loss,
    /// Seed and number of the update: they name the shuffle.
    pub shuffle: (u64, u64),
}

/// Sums of an update.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Loss terms, summed over samples of all passes.
    pub sums: Sums,
    /// Gradient norms of actor and critic, summed over minibatches.
    pub norms: [f64; 2],
    /// Minibatches.
    pub minibatches: f64,
}

/// Runs an update.
///
/// # Errors
/// When the engine fails.
pub fn update(
    learner: &mut Learner<'_>,
    rollout: &Rollout<'_>,
    plan: &Plan,
    workers: &Workers,
) -> Result<Outcome, EngineError> {
    if let Some(engine) = &mut learner.engine {
        engine.hold(rollout);
    }
    let mut places = places(rollout);
    let samples = samples(&places);
    let count = ((samples + plan.minibatch / 2) / plan.minibatch).clamp(1, places.len());
    let mut random = stream("ppo shuffle", plan.shuffle.0, plan.shuffle.1);
    let mut outcome = Outcome::default();
    for _ in 0..plan.epochs {
        for k in (1..places.len()).rev() {
            places.swap(k, below(&mut random, k as u32 + 1) as usize);
        }
        for m in 0..count {
            let [from, to] = [m, m + 1].map(|m| m * places.len() / count);
            let batch = &mut places[from..to];
            outcome.sums.add(&gradient(learner, rollout, plan, workers, batch)?);
            let norms = step(learner, plan, workers);
            outcome.norms.iter_mut().zip(norms).for_each(|(sum, norm)| *sum += norm);
            outcome.minibatches += 1.0;
        }
    }
    Ok(outcome)
}

fn places(rollout: &Rollout<'_>) -> Vec<Place> {
    let mut places = Vec::new();
    for (shard, s) in rollout.shards.iter().enumerate() {
        let (world_steps, uavs) = (s.worlds() * rollout.steps, s.uavs());
        let place = |k| Place { uavs: uavs as u32, shard: shard as u32, first: (k * uavs) as u32 };
        places.extend((0..world_steps).map(place));
    }
    places
}

/// UAVs in these world-steps.
fn samples(places: &[Place]) -> usize {
    places.iter().map(|p| p.uavs as usize).sum()
}

/// Gradient of the mean loss of a minibatch, for both networks: the first of each
/// workspace's `gradients` are the parts to sum.
fn gradient(
    learner: &mut Learner<'_>,
    rollout: &Rollout<'_>,
    plan: &Plan,
    workers: &Workers,
    batch: &mut [Place],
) -> Result<Sums, EngineError> {
    let loss = Loss { samples: samples(batch) as f32, ..plan.loss };
    if let Some(engine) = &mut learner.engine {
        return engine.gradient(rollout, &loss, batch, &mut learner.work[0]);
    }
    // A pass is of worlds of one size. The sort is stable, so it changes nothing where there is but one.
    batch.sort_by_key(|p| p.uavs);
    let parts = learner.work.len();
    let slices = (0..parts).map(|p| &batch[p * batch.len() / parts..(p + 1) * batch.len() / parts]);
    let items = slices.zip(&mut *learner.work).collect();
    let (nets, values) = (&*learner.nets, &learner.values);
    let results = workers.run(items, |_, (slice, work): (&[Place], &mut Workspace)| {
        let sums = part(nets, rollout, &loss, slice, work);
        work.sums.0.store(values[0], &mut work.gradients[0]);
        work.sums.1.store(&mut work.gradients[1]);
        sums
    });
    let mut sums = Sums::default();
    results.iter().for_each(|s| sums.add(s));
    Ok(sums)
}

/// Loss and gradients of a part of a minibatch.
fn part(nets: &Networks, rollout: &Rollout<'_>, loss: &Loss, places: &[Place], work: &mut Workspace) -> Sums {
    let mut sums = Sums::default();
    work.sums.0.clear();
    work.sums.1.clear();
    let of_one_size = places.chunk_by(|a, b| a.uavs == b.uavs);
    let passes = of_one_size.flat_map(|p| p.chunks(worlds_in_pass(p[0].uavs as usize, p.len())));
    for places in passes {
        let uavs = places[0].uavs as usize;
        work.inputs.clear(uavs);
        work.samples.clear();
        for p in places {
            let (s, at) = (&rollout.shards[p.shard as usize], p.first as usize);
            work.inputs.push(s.observations.part(at..at + uavs), &s.links[at..at + uavs]);
            work.samples.extend(rollout.samples(p));
        }
        work.actor.forward(&nets.actor, &work.inputs);
        work.critic.forward(&nets.critic, &work.inputs);
        if let Some(sum) = &mut work.counted {
            *sum += [work.actor.work(&work.inputs), work.critic.work(&work.inputs)].as_flattened().iter().sum::<u64>();
        }
        loss.backward(work.actor.logits_mut(), work.critic.values_mut(), &work.samples, &mut sums);
        work.actor.backward(&nets.actor, &work.inputs, &mut work.sums.0);
        work.critic.backward(&nets.critic, &work.inputs, &mut work.sums.1);
    }
    sums
}

/// A network's parameters as products read them.
enum Net<'n> {
    Actor(&'n mut ActorNet),
    Critic(&'n mut CriticNet),
}

/// A step of both optimisers against the sum of the parts' gradients; returns the norms.
fn step(learner: &mut Learner<'_>, plan: &Plan, workers: &Workers) -> [f64; 2] {
    let nets = [Net::Actor(&mut learner.nets.actor), Net::Critic(&mut learner.nets.critic)];
    // The first part's vectors become the sums.
    let mut parts: [Vec<&mut Vec<f32>>; 2] = [Vec::new(), Vec::new()];
    for work in &mut *learner.work {
        parts.iter_mut().zip(&mut work.gradients).for_each(|(p, g)| p.push(g));
    }
    let both = nets.into_iter().zip(parts).zip(learner.values.iter_mut().zip(&mut learner.adam)).collect();
    let norms = workers.run(both, |_, ((net, parts), (values, adam))| {
        let [sum, rest @ ..] = &mut parts.into_iter().collect::<Vec<_>>()[..] else { return 0.0 };
        for part in rest {
            sum.iter_mut().zip(part.iter()).for_each(|(s, g)| *s += g);
        }
        let norm = adam.step(values, sum, plan.learning_rate, plan.gradient_norm);
        match net {
            Net::Actor(net) => net.load(values),
            Net::Critic(net) => net.load(values),
        }
        norm
    });
    if let Some(engine) = &mut learner.engine {
        engine.load(learner.values.each_ref().map(|v| &v[..]));
    }
    [norms[0], norms[1]]
}
