//! One step of two UAVs, as their nodes would fly it: `fly ACTOR_FILE`.
//!
//! A node does these five things every step; only the radio and the autopilot are missing.

use firmware_core::actor::{Actor, Feature, Mode};
use firmware_core::geometry::{State, TICKS_PER_U, Vec2};
use firmware_core::message::{self, Beacon, Header, MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, Moment, NeighbourTable, PolicyId};
use firmware_core::observation::{Neighbours, Scene, observe};

/// PolicyId seed: the same on every UAV of the swarm.
const SEED: u64 = 10;
/// Half the side of the map, ticks.
const HALF_SIDE: i32 = 100 * TICKS_PER_U;

struct Node<'a> {
    id: u16,
    actor: Actor<'a>,
    table: NeighbourTable,
    view: Neighbours,
    state: State,
    own: Option<Feature>,
}

impl<'a> Node<'a> {
    fn new(id: u16, actor: Actor<'a>, state: State) -> Self {
        let table = NeighbourTable::new(id, PolicyId::of(&actor), DEFAULT_STEP_MS);
        Self { id, actor, table, view: Neighbours::new(), state, own: None }
    }

    fn header(&self, step: u32) -> Header {
        Header { id: self.id, sequence: step as u16, step }
    }

    /// 1. Tell the others where this UAV is.
    fn beacon(&self, now: Moment) -> Message {
        let tie = self.actor.tie_breaker(SEED, self.id, now.step);
        Message::Beacon(Beacon::new(self.header(now.step), now.time_ms, self.state, tie))
    }

    /// 2. and 4. Take in what was received.
    fn hear(&mut self, bytes: &[u8], now: Moment) {
        match Message::decode(bytes) {
            Ok(message) => println!("UAV {} hears: {:?}", self.id, self.table.hear(&message, self.state.position, now)),
            Err(error) => println!("UAV {} drops a message: {error}", self.id),
        }
    }

    /// 3. Observe, encode, and tell the others the feature.
    fn feature(&mut self, pois: &[Vec2], now: Moment) -> Option<Message> {
        self.table.view(self.state.position, now, &mut self.view);
        let tie = self.actor.tie_breaker(SEED, self.id, now.step);
        let scene = Scene { id: self.id, own: self.state, tie, half_side: HALF_SIDE, neighbours: &self.view };
        let own = self.actor.encode(&observe(&scene, pois.iter().copied()));
        self.own = Some(own);
        message::Feature::of(self.header(now.step), self.degree(), &self.actor, &own).map(Message::Feature)
    }

    /// 5. Decide.
    fn decide(&self, step: u32) {
        let Some(own) = &self.own else { return };
        let heard = self.table.features(&self.view, step).map(|(_, feature)| feature);
        let logits = self.actor.logits(own, self.degree(), heard);
        let action = self.actor.choose(&logits, Mode::Sample, SEED, self.id, step);
        println!("UAV {}: action {}, {:?} u/step²", self.id, action.index(), action.acceleration());
    }

    /// Neighbours in view and the UAV itself.
    fn degree(&self) -> u8 {
        self.view.as_slice().len() as u8 + 1
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: fly ACTOR_FILE")?;
    let file = std::fs::read(path)?;
    let actor = Actor::load(&file)?;
    actor.self_test()?; // No flight without it.
    let at = |x, y| State { position: Vec2::from_u(x, y), velocity: Vec2::default() };
    let mut nodes = [Node::new(1, actor, at(100.0, 100.0)), Node::new(2, actor, at(112.0, 104.0))];
    let pois = [Vec2::from_u(97.0, 108.0), Vec2::from_u(104.0, 96.0), Vec2::from_u(118.0, 110.0)];
    let now = Moment { step: 0, time_ms: 0 };

    let beacons = [0, 1].map(|i| nodes[i].beacon(now));
    exchange(&mut nodes, &beacons, now);
    let features: Vec<Message> = nodes.iter_mut().filter_map(|node| node.feature(&pois, now)).collect();
    exchange(&mut nodes, &features, now);
    nodes.iter().for_each(|node| node.decide(now.step));
    Ok(())
}

/// A radio that everyone hears, the sender too: its table drops what carries its own id.
fn exchange(nodes: &mut [Node<'_>], messages: &[Message], now: Moment) {
    for message in messages {
        let mut buffer = [0; MAX_LEN];
        let bytes = message.encode(&mut buffer);
        nodes.iter_mut().for_each(|node| node.hear(bytes, now));
    }
}
