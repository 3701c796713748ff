//! The update: several passes over a segment in minibatches, each split into parts
//! whose gradients are summed in a fixed order.

use super::adam::Adam;
use super::advantage::ValueNorm;
use super::ppo::{Loss, Sample, Sums};
use super::shard::{Shard, floats};
use super::workers::Workers;
use crate::net::{ActorTensors, Batch, CriticTensors, Layout, actor_logits, critic_values};
use burn::tensor::{Device, Tensor, TensorData};
use covey_env::random::{below, stream};
use firmware_core::actor::Aggregation;

/// A world-step of the segment.
#[derive(Clone, Copy)]
struct Place {
    shard: u32,
    /// Index of its first UAV in the shard's arrays.
    first: u32,
}

/// What an update needs besides the networks.
pub struct Segment<'s> {
    /// The shards, played.
    pub shards: &'s [Shard],
    /// UAVs in a world.
    pub uavs: usize,
    /// Steps in the segment.
    pub steps: usize,
    /// Mean and deviation of the advantages.
    pub advantage: (f64, f64),
    /// Normalisation of returns.
    pub norm: ValueNorm,
}

/// Both networks with their optimisers.
pub struct Learner<'l> {
    /// Form of the actor.
    pub aggregation: Aggregation,
    /// Layouts of actor and critic.
    pub layouts: [&'l Layout; 2],
    /// Their parameters.
    pub values: [&'l mut Vec<f32>; 2],
    /// Their optimisers.
    pub adam: [&'l mut Adam; 2],
}

/// How to update.
pub struct Plan {
    /// Passes.
    pub epochs: u32,
    /// Agent samples in a minibatch.
    pub minibatch: usize,
    /// Parts of a minibatch.
    pub parts: usize,
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
pub fn update(learner: &mut Learner<'_>, segment: &Segment<'_>, plan: &Plan, workers: &Workers) -> Outcome {
    let mut places = places(segment);
    let count = ((places.len() * segment.uavs + plan.minibatch / 2) / plan.minibatch).clamp(1, places.len());
    let mut random = stream("ppo shuffle", plan.shuffle.0, plan.shuffle.1);
    let mut outcome = Outcome::default();
    let mut gradients = [0, 1].map(|k| vec![0.0; learner.layouts[k].len()]);
    for _ in 0..plan.epochs {
        for k in (1..places.len()).rev() {
            places.swap(k, below(&mut random, k as u32 + 1) as usize);
        }
        for m in 0..count {
            let batch = &places[m * places.len() / count..(m + 1) * places.len() / count];
            let sums = gradient(learner, segment, plan, workers, batch, &mut gradients);
            outcome.sums.add(&sums);
            let networks = learner.adam.iter_mut().zip(&mut learner.values).zip(&gradients);
            for (norm, ((adam, values), gradient)) in outcome.norms.iter_mut().zip(networks) {
                *norm += adam.step(values, gradient, plan.learning_rate, plan.gradient_norm);
            }
            outcome.minibatches += 1.0;
        }
    }
    outcome
}

fn places(segment: &Segment<'_>) -> Vec<Place> {
    let mut places = Vec::new();
    for (shard, s) in segment.shards.iter().enumerate() {
        let world_steps = s.worlds() * segment.steps;
        places.extend((0..world_steps).map(|k| Place { shard: shard as u32, first: (k * segment.uavs) as u32 }));
    }
    places
}

/// Gradient of the mean loss of a minibatch, for both networks.
fn gradient(
    learner: &Learner<'_>,
    segment: &Segment<'_>,
    plan: &Plan,
    workers: &Workers,
    batch: &[Place],
    out: &mut [Vec<f32>; 2],
) -> Sums {
    let device = Device::flex();
    let tensors = [0, 1].map(|k| learner.layouts[k].tensors(learner.values[k], &device));
    let loss = Loss { samples: (batch.len() * segment.uavs) as f32, ..plan.loss };
    let parts = plan.parts.min(batch.len());
    let slices = (0..parts).map(|p| &batch[p * batch.len() / parts..(p + 1) * batch.len() / parts]).collect();
    let results = workers.run(slices, |_, slice: &[Place]| part(learner, segment, &tensors, &loss, slice));
    let mut sums = Sums::default();
    out.iter_mut().for_each(|g| g.fill(0.0));
    for (part_sums, part_gradients) in results {
        sums.add(&part_sums);
        for (sum, part) in out.iter_mut().zip(part_gradients) {
            sum.iter_mut().zip(part).for_each(|(s, g)| *s += g);
        }
    }
    sums
}

/// Loss and gradients of a part of a minibatch.
fn part(
    learner: &Learner<'_>,
    segment: &Segment<'_>,
    tensors: &[Vec<Tensor<2>>; 2],
    loss: &Loss,
    places: &[Place],
) -> (Sums, [Vec<f32>; 2]) {
    let leaves =
        [0, 1].map(|k| -> Vec<Tensor<2>> { tensors[k].iter().map(|t| t.clone().autodiff().require_grad()).collect() });
    let batch = gather(segment, learner.aggregation, places);
    let logits = actor_logits(&ActorTensors::new(&leaves[0], learner.aggregation), &batch);
    let values = critic_values(&CriticTensors(&leaves[1]), &batch);
    let mut by_logits = floats(logits.clone().inner());
    let mut by_values = floats(values.clone().inner());
    let mut sums = Sums::default();
    let (mean, deviation) = segment.advantage;
    let width = by_logits.len() / by_values.len();
    let agents = places.iter().flat_map(|p| (0..segment.uavs).map(move |i| (p.shard as usize, p.first as usize + i)));
    for ((row, v), (shard, at)) in by_logits.chunks_exact_mut(width).zip(&mut by_values).zip(agents) {
        let s = &segment.shards[shard];
        let sample = Sample {
            action: s.actions[at].index(),
            log_probability: s.log_probabilities[at],
            advantage: ((f64::from(s.advantages[at]) - mean) / (deviation + 1e-8)) as f32,
            target: segment.norm.normalise(s.returns[at]),
        };
        *v = loss.sample(row, *v, &sample, &mut sums);
    }
    let gradients = [
        backward(logits, by_logits, learner.layouts[0], &leaves[0]),
        backward(values, by_values, learner.layouts[1], &leaves[1]),
    ];
    (sums, gradients)
}

/// Carries the gradient at a network's output back to its parameters.
fn backward(output: Tensor<2>, by_output: Vec<f32>, layout: &Layout, leaves: &[Tensor<2>]) -> Vec<f32> {
    let shape = output.dims();
    let weights = Tensor::<2>::from_data(TensorData::new(by_output, shape), &Device::flex()).autodiff();
    let mut gradients = (output * weights).sum().backward();
    let mut sum = vec![0.0; layout.len()];
    layout.add_gradients(leaves, &mut gradients, &mut sum);
    sum
}

fn gather(segment: &Segment<'_>, aggregation: Aggregation, places: &[Place]) -> Batch {
    let mut observations = Vec::with_capacity(places.len() * segment.uavs);
    let mut links = Vec::with_capacity(places.len() * segment.uavs);
    for p in places {
        let (s, at) = (&segment.shards[p.shard as usize], p.first as usize);
        observations.extend_from_slice(&s.observations[at..at + segment.uavs]);
        links.extend_from_slice(&s.links[at..at + segment.uavs]);
    }
    Batch::new(&observations, &links, segment.uavs, aggregation, &Device::flex().autodiff())
}
