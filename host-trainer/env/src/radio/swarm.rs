//! A swarm of on-board agents that know of each other only by the messages that the radio channel delivers.

use super::channel::RadioChannel;
use super::error::RadioError;
use super::figures::RadioFigures;
use super::settings::RadioSettings;
use crate::world::World;
use firmware_core::agent::{Agent, AgentSettings};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, State, TICKS_PER_U, Vec2};
use firmware_core::message::{FeatureMessage, MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, Moment};
use firmware_core::observation::BuildObservation;

/// When a UAV observes, encodes and broadcasts its feature, ms after the beginning of the step, when its beacon went
/// out.
pub const ENCODE_MS: u64 = 400;
/// When a UAV decides on its action, ms after the beginning of the step.
pub const DECIDE_MS: u64 = 800;
/// Length of a step, ms.
pub(super) const STEP_MS: u64 = DEFAULT_STEP_MS as u64;
/// Margin of a range query, u, so that rounding to ticks leaves no UAV out.
const MARGIN_U: f32 = 0.01;

/// The channel and the agents.
#[derive(Clone, Debug)]
pub(super) struct Swarm {
    pub(super) channel: RadioChannel,
    /// One for each UAV; its index is its id.
    pub(super) agents: Vec<Agent>,
    /// What the agents share; each has its own id.
    shared: AgentSettings,
    /// The UAVs' own states in the present step.
    states: Vec<State>,
    figures: RadioFigures,
}

impl Swarm {
    /// A swarm of `uavs` agents that share these settings, but for the id.
    pub(super) fn new(settings: &RadioSettings, uavs: usize, shared: AgentSettings) -> Result<Self, RadioError> {
        let channel = RadioChannel::new(settings, uavs, shared.policy_seed)?;
        // RadioChannel::new bounds the number by MAX_NODES.
        let agents = (0..uavs as u16).map(|id| Agent::new(AgentSettings { id, ..shared })).collect();
        let states = vec![State::default(); uavs];
        Ok(Self { channel, agents, shared, states, figures: RadioFigures::default() })
    }

    /// Begins an episode with these settings: neighbour tables are empty. The channel's random numbers follow from the
    /// policy seed.
    pub(super) fn begin(&mut self, shared: AgentSettings) {
        self.channel.reset(shared.policy_seed);
        self.figures = RadioFigures::default();
        self.shared = shared;
        self.reset_agents();
    }

    fn reset_agents(&mut self) {
        for (id, agent) in (0u16..).zip(&mut self.agents) {
            agent.reset(AgentSettings { id, ..self.shared });
        }
    }

    /// What the agents share.
    pub(super) const fn shared(&self) -> AgentSettings {
        self.shared
    }

    /// The exchange of a step in the present state of `world`: the agents' beacons, their observations (one for each
    /// UAV is written to `observations`), and the features that `encode` lets an agent make of its observation.
    pub(super) fn exchange<O: BuildObservation>(
        &mut self,
        world: &World,
        observations: &mut [O],
        encode: impl FnMut(&mut Agent, &O, u16) -> Option<FeatureMessage>,
    ) {
        let uavs = world.scenario().uavs;
        assert!(uavs == self.agents.len(), "exchange: {uavs} UAVs, the swarm was made for {}", self.agents.len());
        let half_side = world.scenario().half_side_ticks();
        if self.shared.half_side != half_side {
            // The first step on another map.
            self.shared.half_side = half_side;
            self.reset_agents();
        }
        let step = world.steps_done();
        let begin_ms = u64::from(step) * STEP_MS;
        let now = Moment { step, time_ms: begin_ms as u32 };
        self.send_beacons(world, now, begin_ms);
        self.receive(now, begin_ms + ENCODE_MS);
        self.observe(world, now, begin_ms + ENCODE_MS, observations, encode);
        self.receive(now, begin_ms + DECIDE_MS);
        self.count_beliefs(world);
    }

    /// What the channel has done in this episode.
    pub(super) fn figures(&self) -> RadioFigures {
        RadioFigures { counts: self.channel.counts(), ..self.figures }
    }

    fn send_beacons(&mut self, world: &World, now: Moment, now_ms: u64) {
        for i in 0..self.agents.len() {
            self.channel.set_position(i, world.position(i));
        }
        for (i, (agent, state)) in self.agents.iter().zip(&mut self.states).enumerate() {
            let ((x, y), (vx, vy)) = (world.position(i), world.velocity(i));
            *state = State { position: Vec2::from_u(x, y), velocity: Vec2::from_u(vx, vy) };
            let beacon = agent.beacon(now, sequence(now), *state);
            send(&mut self.channel, now_ms, i, &Message::Beacon(beacon));
        }
    }

    /// Hands every agent the messages that have arrived by `now_ms`.
    fn receive(&mut self, now: Moment, now_ms: u64) {
        for (i, (agent, state)) in self.agents.iter_mut().zip(&self.states).enumerate() {
            while let Some(datagram) = self.channel.poll(now_ms, i) {
                match Message::decode(datagram.bytes) {
                    Ok(message) => self.figures.add_answer(agent.hear(&message, state.position, now)),
                    Err(_) => self.figures.malformed += 1,
                }
            }
        }
    }

    fn observe<O: BuildObservation>(
        &mut self,
        world: &World,
        now: Moment,
        now_ms: u64,
        observations: &mut [O],
        mut encode: impl FnMut(&mut Agent, &O, u16) -> Option<FeatureMessage>,
    ) {
        let agents = self.agents.iter_mut().zip(&self.states);
        for (i, ((agent, state), observation)) in agents.zip(observations).enumerate() {
            *observation = agent.observe(now, *state, world.poi_ticks_near(i));
            if let Some(feature) = encode(agent, observation, sequence(now)) {
                send(&mut self.channel, now_ms, i, &Message::Feature(feature));
            }
        }
    }

    /// Compares the neighbours that every agent believes in range with those that are.
    fn count_beliefs(&mut self, world: &World) {
        let states = &self.states;
        for (i, (agent, state)) in self.agents.iter().zip(states).enumerate() {
            // Bit errors make ids that no UAV has.
            let in_range = |j: usize| {
                let offset = states.get(j).map(|other| other.position - state.position);
                offset.is_some_and(|o| o.within(COMMUNICATION_RANGE_U * TICKS_PER_U).is_some())
            };
            let (x, y) = world.position(i);
            let near = world.uavs_within(x, y, COMMUNICATION_RANGE_U as f32 + MARGIN_U);
            let neighbours = near.filter(|&j| j != i && in_range(j)).count();
            let believed = agent.neighbours().as_slice().iter().map(|n| in_range(usize::from(n.id)));
            self.figures.add_belief(neighbours, believed, agent.features().count());
        }
    }
}

/// The sequence number of a step's messages: a UAV sends one beacon and one feature in each.
const fn sequence(now: Moment) -> u16 {
    now.step as u16
}

fn send(channel: &mut RadioChannel, now_ms: u64, from: usize, message: &Message) {
    channel.broadcast(now_ms, from, message.encode(&mut [0; MAX_LEN]));
}
