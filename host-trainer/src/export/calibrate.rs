//! Calibration: how large activations get on rollouts.

use crate::eval::Watch;
use crate::float_actor::{FloatActor, FloatPolicy};
use covey_env::{Neighbourhood, ObservationBatch, Scenario, ScenarioError, World};
use covey_net::{ActorNet, Rows};
use firmware_core::action::Action;
use firmware_core::actor::Mode;
use rayon::prelude::*;

/// Greatest magnitude of every channel of the hidden layers' activations, one number a channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranges {
    /// First hidden layer of the encoder.
    pub hidden: Vec<f32>,
    /// Feature `h`, the encoder's output.
    pub feature: Vec<f32>,
    /// Neighbours' features as combined by the aggregation; empty without one, and with GATv2.
    pub combined: Vec<f32>,
    /// GATv2: what a UAV scores with, `W_l h`; else empty.
    pub receiver: Vec<f32>,
    /// GATv2: what it broadcasts, `W_r h`; else empty.
    pub sender: Vec<f32>,
    /// What the head takes beside the feature: the graph layer's output, with GATv2 the combined
    /// features. Empty without aggregation.
    pub graph: Vec<f32>,
    /// Hidden layer of the head.
    pub head: Vec<f32>,
}

/// What the UAVs of a world observed at a step, with the float policy's logits.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Observations of all UAVs.
    pub observations: ObservationBatch,
    /// The neighbours that each UAV kept, one entry a UAV.
    pub neighbourhoods: Vec<Neighbourhood>,
    /// Logits, UAV by UAV, 17 each.
    pub logits: Vec<f32>,
}

fn widen(range: &mut Vec<f32>, activations: &Rows) {
    range.resize(activations.width(), 0.0);
    for r in 0..activations.rows() {
        range.iter_mut().zip(activations.row(r)).for_each(|(m, a)| *m = m.max(a.abs()));
    }
}

impl Ranges {
    fn merge(mut self, o: Self) -> Self {
        let both = |a: &mut Vec<f32>, b: Vec<f32>| {
            a.resize(b.len().max(a.len()), 0.0);
            a.iter_mut().zip(b).for_each(|(a, b)| *a = a.max(b));
        };
        both(&mut self.hidden, o.hidden);
        both(&mut self.feature, o.feature);
        both(&mut self.combined, o.combined);
        both(&mut self.receiver, o.receiver);
        both(&mut self.sender, o.sender);
        both(&mut self.graph, o.graph);
        both(&mut self.head, o.head);
        self
    }
}

/// Flies the float policy in worlds 0 to `worlds` − 1 of `seed` and returns the ranges of its
/// activations and every situation met. Tells `watch` how far it is.
///
/// # Errors
/// When the scenario cannot be built.
pub fn calibrate(
    actor: &FloatActor,
    scenario: &Scenario,
    seed: u64,
    worlds: u32,
    watch: Watch<'_>,
) -> Result<(Ranges, Vec<Situation>), ScenarioError> {
    let fresh = World::new(scenario)?;
    let net = actor.network();
    let flown: Vec<_> = (0..u64::from(worlds))
        .into_par_iter()
        .map(|index| {
            let mut world = fresh.clone();
            world.reset(seed, index);
            fly(actor, &net, &mut world, seed.wrapping_add(index), watch)
        })
        .collect();
    let mut ranges = Ranges::default();
    let mut situations = Vec::new();
    for (r, s) in flown {
        ranges = ranges.merge(r);
        situations.extend(s);
    }
    Ok((ranges, situations))
}

fn fly(actor: &FloatActor, net: &ActorNet, world: &mut World, seed: u64, watch: Watch<'_>) -> (Ranges, Vec<Situation>) {
    let mut ranges = Ranges::default();
    let mut situations = Vec::new();
    let mut policy = FloatPolicy::new(actor, net, seed, Mode::Sample);
    let mut actions = vec![Action::COAST; world.scenario().uavs];
    while !world.done() {
        let pass = policy.forward(world);
        widen(&mut ranges.hidden, pass.hidden());
        widen(&mut ranges.feature, pass.feature());
        for (range, activations) in [(&mut ranges.combined, pass.combined()), (&mut ranges.graph, pass.graph())] {
            activations.into_iter().for_each(|a| widen(range, a));
        }
        if let Some([receiver, sender]) = pass.ends() {
            widen(&mut ranges.receiver, receiver);
            widen(&mut ranges.sender, sender);
        }
        widen(&mut ranges.head, pass.head());
        let logits = (0..actions.len()).flat_map(|id| pass.logits().row(id)).copied().collect();
        policy.select_actions(world, &mut actions);
        let (observations, neighbourhoods) = policy.observed();
        situations.push(Situation {
            observations: observations.clone(),
            neighbourhoods: neighbourhoods.to_vec(),
            logits,
        });
        world.step(&actions);
        watch(actions.len() as u64);
    }
    (ranges, situations)
}
