//! The float policy: the trained network as it is.

use crate::net::{ActorTensors, Batch, Layout, actor_logits, dimensions};
use crate::settings::Settings;
use crate::train::{floats, log_softmax, pick};
use burn::tensor::{Device, Tensor};
use covey_env::{Links, Observer, Policy, World};
use firmware_core::action::Action;
use firmware_core::actor::{Aggregation, Dimensions, Mode};
use firmware_core::observation::{LEN, Observation};
use firmware_core::random::action_draw;

/// A trained actor in floats.
#[derive(Clone, Debug)]
pub struct FloatActor {
    /// Form.
    pub aggregation: Aggregation,
    /// Widths.
    pub dimensions: Dimensions,
    /// Steps for which a tie-breaker holds.
    pub tie_period: u32,
    /// Places of the parameters.
    pub layout: Layout,
    /// The parameters.
    pub values: Vec<f32>,
}

impl FloatActor {
    /// From the parameters of a run with these settings; `temperature` is applied to the
    /// output layer.
    #[must_use]
    pub fn new(s: &Settings, mut values: Vec<f32>) -> Self {
        let dimensions = dimensions(s);
        let aggregation = s.graph.0;
        let layout = Layout::actor(dimensions, aggregation);
        for piece in layout.pieces().iter().filter(|p| p.name.starts_with("output")) {
            values[piece.start..piece.start + piece.len()].iter_mut().for_each(|v| *v /= s.temperature as f32);
        }
        Self { aggregation, dimensions, tie_period: s.tie_period, layout, values }
    }

    /// Its tensors, for passes without gradients.
    #[must_use]
    pub fn tensors(&self) -> Vec<Tensor<2>> {
        self.layout.tensors(&self.values, &Device::flex())
    }
}

/// The float policy in a world.
pub struct FloatPolicy<'t> {
    tensors: ActorTensors<'t>,
    aggregation: Aggregation,
    observer: Observer,
    seed: u64,
    mode: Mode,
    observations: Vec<Observation>,
    links: Vec<Links>,
}

impl<'t> FloatPolicy<'t> {
    /// `tensors` are those of `actor`; `seed` seeds the on-board random numbers.
    #[must_use]
    pub fn new(actor: &FloatActor, tensors: &'t [Tensor<2>], seed: u64, mode: Mode) -> Self {
        Self {
            tensors: ActorTensors::new(tensors, actor.aggregation),
            aggregation: actor.aggregation,
            observer: Observer::new(seed, actor.tie_period),
            seed,
            mode,
            observations: Vec::new(),
            links: Vec::new(),
        }
    }

    /// The batch of what the UAVs of a world see.
    pub fn look(&mut self, world: &World) -> Batch {
        let n = world.scenario().uavs;
        self.observations.resize(n, [0; LEN]);
        self.links.resize(n, Links::default());
        self.observer.observe(world, &mut self.observations, &mut self.links);
        Batch::new(&self.observations, &self.links, n, self.aggregation, &Device::flex())
    }

    /// The observations and neighbours of the last [`Self::look`].
    #[must_use]
    pub fn seen(&self) -> (&[Observation], &[Links]) {
        (&self.observations, &self.links)
    }

    /// Writes the actions of these logits.
    pub fn choose(&self, world: &World, logits: &[f32], actions: &mut [Action]) {
        let rows = logits.chunks_exact(logits.len() / actions.len());
        for (id, (row, action)) in rows.zip(actions).enumerate() {
            *action = match self.mode {
                Mode::Argmax => argmax(row),
                Mode::Sample => {
                    let draw = f64::from(action_draw(self.seed, id as u16, world.steps_done())) / (1u64 << 32) as f64;
                    pick(&log_softmax(row), draw)
                }
            };
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
        let batch = self.look(world);
        let logits = floats(actor_logits(&self.tensors, &batch));
        self.choose(world, &logits, actions);
    }
}
