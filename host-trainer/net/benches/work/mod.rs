//! Fixed work of the sizes that training has, for clocks and for counting instructions.

#[path = "../../../../firmware-core/tests/common/mod.rs"]
mod sample;

use covey_env::baselines::Centroid;
use covey_env::{ActorPolicy, Neighbourhood, Observer, Policy, Scenario, World};
use covey_net::{
    ActorGradient, ActorNet, ActorPass, CriticGradient, CriticNet, CriticPass, Inputs, ParameterLayout, initialise,
    micro_batch_size,
};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::actor::{Actor, Aggregation, Dimensions, Mode};
use firmware_core::observation::{LEN, Observation};

/// UAVs in a world.
pub const UAVS: usize = 20;
/// The default widths.
const WIDTHS: Dimensions =
    Dimensions { observation: LEN as u16, hidden: 128, feature: 64, head: 64, actions: ACTIONS as u16 };

/// An actor file of the default widths with made-up weights, GCN.
pub fn actor_file() -> Vec<u8> {
    sample::actor_of(WIDTHS, Aggregation::Gcn, 1)
}

/// The default world k² times, with as many UAVs and PoIs to the area and shorter flights.
pub fn large(k: usize) -> Scenario {
    let base = Scenario::default();
    Scenario {
        uavs: UAVS * k * k,
        pois: base.pois * k * k,
        side_u: base.side_u * k as f32,
        steps: base.steps / k as u32,
        ..base
    }
}

/// A world that the int8 actor flies, as in an evaluation.
pub struct Flight<'a> {
    world: World,
    policy: ActorPolicy<'a>,
    actions: Vec<Action>,
}

impl<'a> Flight<'a> {
    /// Flown by this actor.
    pub fn new(scenario: &Scenario, actor: Actor<'a>) -> Self {
        let world = World::new(scenario).expect("a sound scenario");
        Self { world, policy: ActorPolicy::new(actor, 1, Mode::Sample), actions: vec![Action::COAST; scenario.uavs] }
    }

    /// A whole episode.
    pub fn episode(&mut self) {
        self.world.reset(0, 0);
        self.policy.begin(&self.world);
        while !self.world.done() {
            self.policy.act(&self.world, &mut self.actions);
            self.world.step(&self.actions);
        }
    }

    /// Agent-steps of an episode.
    pub fn agent_steps(&self) -> u64 {
        u64::from(self.world.scenario().steps) * self.actions.len() as u64
    }
}

/// A world with a script of actions, played over and over.
pub struct Environment {
    world: World,
    script: Vec<Vec<Action>>,
    observer: Observer,
    observations: Vec<Observation>,
    neighbours: Vec<Neighbourhood>,
}

impl Environment {
    /// Flown by the centroid heuristic, so that groups form and PoIs are seen.
    pub fn new(scenario: &Scenario) -> Self {
        let mut world = World::new(scenario).expect("a sound scenario");
        let mut policy = Centroid::new(1, 0);
        policy.begin(&world);
        let mut actions = vec![Action::COAST; scenario.uavs];
        let mut script = Vec::new();
        while !world.done() {
            policy.act(&world, &mut actions);
            world.step(&actions);
            script.push(actions.clone());
        }
        let (observations, neighbours) = (vec![[0; LEN]; scenario.uavs], vec![Neighbourhood::default(); scenario.uavs]);
        Self { world, script, observer: Observer::new(1, 1_000_000), observations, neighbours }
    }

    /// A whole episode with the observations of every step.
    pub fn episode(&mut self) {
        self.world.reset(0, 0);
        for actions in &self.script {
            self.world.step(actions);
            self.observer.observe(&self.world, &mut self.observations, &mut self.neighbours);
        }
    }

    /// Agent-steps of an episode.
    pub fn agent_steps(&self) -> u64 {
        (self.script.len() * self.observations.len()) as u64
    }
}

/// Both networks of the default widths with the observations of some world-steps.
pub struct Networks {
    actor: ActorNet,
    critic: CriticNet,
    actor_pass: ActorPass,
    critic_pass: CriticPass,
    actor_gradient: ActorGradient,
    critic_gradient: CriticGradient,
    inputs: Inputs,
    observations: Vec<Observation>,
    neighbours: Vec<Neighbourhood>,
}

impl Networks {
    /// With the observations of `world_steps` states, from the beginnings and ends of flights.
    pub fn new(aggregation: Aggregation, world_steps: usize) -> Self {
        let layouts = [ParameterLayout::actor(WIDTHS, aggregation), ParameterLayout::critic(WIDTHS)];
        let (mut actor, mut critic) = (ActorNet::new(&layouts[0], aggregation), CriticNet::new(&layouts[1]));
        actor.load(&parameters(&layouts[0]));
        critic.load(&parameters(&layouts[1]));
        let (observations, neighbours) = situations(world_steps);
        let mut networks = Self {
            actor,
            critic,
            actor_pass: ActorPass::new(&layouts[0]),
            critic_pass: CriticPass::new(&layouts[1]),
            actor_gradient: ActorGradient::new(&layouts[0]),
            critic_gradient: CriticGradient::new(&layouts[1]),
            inputs: Inputs::new(LEN),
            observations,
            neighbours,
        };
        networks.set_inputs(0..world_steps.min(micro_batch_size(UAVS, world_steps)));
        networks
    }

    /// Samples of a micro-batch.
    pub fn micro_batch(&self) -> u64 {
        self.inputs.neighbours().len() as u64
    }

    /// Samples of a minibatch.
    pub fn samples(&self) -> u64 {
        self.observations.len() as u64
    }

    fn set_inputs(&mut self, world_steps: std::ops::Range<usize>) {
        let range = world_steps.start * UAVS..world_steps.end * UAVS;
        self.inputs.clear(UAVS);
        self.inputs.push(&self.observations[range.clone()], &self.neighbours[range]);
    }

    /// Logits of a micro-batch.
    pub fn actor_forward(&mut self) {
        self.actor_pass.forward(&self.actor, &self.inputs);
    }

    /// Values of a micro-batch.
    pub fn critic_forward(&mut self) {
        self.critic_pass.forward(&self.critic, &self.inputs);
    }

    /// Gradient of the actor over a micro-batch.
    pub fn actor_gradient(&mut self) {
        self.actor_forward();
        slopes(self.actor_pass.logits_mut().values_mut());
        self.actor_pass.backward(&self.actor, &self.inputs, &mut self.actor_gradient);
    }

    /// Gradient of the critic over a micro-batch.
    pub fn critic_gradient(&mut self) {
        self.critic_forward();
        slopes(self.critic_pass.values_mut().values_mut());
        self.critic_pass.backward(&self.critic, &self.inputs, &mut self.critic_gradient);
    }

    /// Gradients of both over all world-steps, micro-batch by micro-batch.
    pub fn minibatch(&mut self) {
        self.actor_gradient.clear();
        self.critic_gradient.clear();
        let world_steps = self.observations.len() / UAVS;
        let micro_batch = micro_batch_size(UAVS, world_steps);
        for first in (0..world_steps).step_by(micro_batch) {
            self.set_inputs(first..(first + micro_batch).min(world_steps));
            self.actor_gradient();
            self.critic_gradient();
        }
    }
}

/// Some gradient by the outputs.
fn slopes(outputs: &mut [f32]) {
    outputs.iter_mut().enumerate().for_each(|(k, g)| *g = (k % 7) as f32 - 3.0);
}

/// Fresh weights with biases that let through as much as those of a trained network.
fn parameters(layout: &ParameterLayout) -> Vec<f32> {
    let mut values = initialise(layout, "work", 1);
    for block in layout.blocks() {
        let bias = match block.name {
            "encoder1 bias" => 0.05,
            "encoder2 bias" => 0.45,
            "graph bias" => 0.15,
            "head bias" => 1.0,
            _ => 0.0,
        };
        values[block.start..block.start + block.len()].iter_mut().for_each(|v| *v += bias);
    }
    values
}

/// Observations and neighbours of as many world-steps, each of another flight.
fn situations(world_steps: usize) -> (Vec<Observation>, Vec<Neighbourhood>) {
    let scenario = Scenario::default();
    let mut world = World::new(&scenario).expect("a sound scenario");
    let mut observer = Observer::new(9, 1_000_000);
    let mut actions = vec![Action::COAST; UAVS];
    let mut observations = vec![[0; LEN]; world_steps * UAVS];
    let mut neighbours = vec![Neighbourhood::default(); world_steps * UAVS];
    for (k, (observations, neighbours)) in
        observations.chunks_exact_mut(UAVS).zip(neighbours.chunks_exact_mut(UAVS)).enumerate()
    {
        world.reset(5, k as u64);
        let mut policy = Centroid::new(1, k as u64);
        policy.begin(&world);
        for _ in 0..k * 7 % 40 {
            policy.act(&world, &mut actions);
            world.step(&actions);
        }
        observer.observe(&world, observations, neighbours);
    }
    (observations, neighbours)
}
