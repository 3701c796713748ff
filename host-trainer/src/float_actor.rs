//! The trained actor in floats, before quantisation, and the policy that flies by it.

use crate::rollout::sample;
use crate::settings::Settings;
use crate::train::dimensions;
use covey_env::{Neighbourhood, ObservationBatch, ObservationForm, ObservationSliceMut, Observer, Policy, World};
use covey_net::{ActorNet, ActorPass, Inputs, ParameterLayout, Rows};
use firmware_core::action::Action;
use firmware_core::actor::{Aggregation, Dimensions, Mode};
use firmware_core::random::action_draw;

/// A trained actor in floats.
#[derive(Clone, Debug)]
pub struct FloatActor {
    /// Form of the observation that it takes.
    pub observation: ObservationForm,
    /// How it combines the features of a neighbourhood.
    pub aggregation: Aggregation,
    /// Widths of its layers.
    pub dimensions: Dimensions,
    /// Steps for which a tie-breaker holds.
    pub tie_period: u32,
    /// Where each block of parameters lies in `values`.
    pub layout: ParameterLayout,
    /// The parameters.
    pub values: Vec<f32>,
}

impl FloatActor {
    /// From the parameters of a run with these settings. Weights and bias of the output layer are
    /// divided by `temperature`, and so are the logits.
    #[must_use]
    pub fn new(s: &Settings, mut values: Vec<f32>) -> Self {
        let dimensions = dimensions(s);
        let aggregation = s.graph;
        let layout = ParameterLayout::actor(dimensions, aggregation);
        for block in layout.blocks().iter().filter(|p| p.name.starts_with("output")) {
            values[block.start..block.start + block.len()].iter_mut().for_each(|v| *v /= s.temperature as f32);
        }
        Self { observation: s.observation, aggregation, dimensions, tie_period: s.tie_period, layout, values }
    }

    /// The network with these parameters, ready for forward passes.
    #[must_use]
    pub fn network(&self) -> ActorNet {
        let mut net = ActorNet::new(&self.layout, self.aggregation);
        net.load(&self.values);
        net
    }
}

/// The float policy in a world: [`Self::forward`] and [`Self::select_actions`] each step, or both
/// as [`Policy::act`].
pub struct FloatPolicy<'n> {
    net: &'n ActorNet,
    inputs: Inputs,
    pass: ActorPass,
    observer: Observer,
    seed: u64,
    mode: Mode,
    observations: ObservationBatch,
    neighbours: Vec<Neighbourhood>,
    draws: Vec<f64>,
}

impl<'n> FloatPolicy<'n> {
    /// `net` is the actor's [network](FloatActor::network); `seed` seeds the on-board random numbers.
    #[must_use]
    pub fn new(actor: &FloatActor, net: &'n ActorNet, seed: u64, mode: Mode) -> Self {
        Self {
            net,
            inputs: Inputs::of(actor.observation),
            pass: ActorPass::new(&actor.layout),
            observer: Observer::new(seed, actor.tie_period),
            seed,
            mode,
            observations: ObservationBatch::new(actor.observation, 0),
            neighbours: Vec::new(),
            draws: Vec::new(),
        }
    }

    /// Observes the present state of a world and runs the actor on it; returns its activations, a
    /// row a UAV.
    pub fn forward(&mut self, world: &World) -> &ActorPass {
        let n = world.scenario().uavs;
        self.observations.resize(n);
        self.neighbours.resize(n, Neighbourhood::default());
        match self.observations.part_mut(0..n) {
            ObservationSliceMut::Compact(out) => self.observer.observe(world, out, &mut self.neighbours),
            ObservationSliceMut::Cells(out) => self.observer.observe(world, out, &mut self.neighbours),
        }
        self.inputs.clear(n);
        self.inputs.push(&self.observations, &self.neighbours);
        self.pass.forward(self.net, &self.inputs);
        &self.pass
    }

    /// The observations and kept neighbours of the last [`Self::forward`], one a UAV.
    #[must_use]
    pub fn observed(&self) -> (&ObservationBatch, &[Neighbourhood]) {
        (&self.observations, &self.neighbours)
    }

    /// Logits of the last [`Self::forward`], 17 a UAV.
    #[must_use]
    pub const fn logits(&self) -> &Rows {
        self.pass.logits()
    }

    /// Writes the actions of all UAVs from the logits of the last [`Self::forward`].
    pub fn select_actions(&mut self, world: &World, actions: &mut [Action]) {
        let logits = self.pass.logits();
        match self.mode {
            Mode::Argmax => actions.iter_mut().enumerate().for_each(|(id, a)| *a = argmax(logits.row(id))),
            Mode::Sample => {
                let draw = |id: usize| action_draw(self.seed, id as u16, world.steps_done());
                self.draws.clear();
                self.draws.extend((0..actions.len()).map(|id| f64::from(draw(id)) / (1u64 << 32) as f64));
                sample(logits.values(), &self.draws, |id, action, _| actions[id] = action);
            }
        }
    }
}

/// The action of the greatest logit; of equal ones the first.
#[must_use]
pub fn argmax(logits: &[f32]) -> Action {
    let mut best = (f32::NEG_INFINITY, Action::COAST);
    for (action, &l) in Action::all().zip(logits) {
        if l > best.0 {
            best = (l, action);
        }
    }
    best.1
}

impl Policy for FloatPolicy<'_> {
    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.forward(world);
        self.select_actions(world, actions);
    }
}
