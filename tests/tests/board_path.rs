//! Whole episodes flown the way boards fly: every UAV has its own neighbour table and
//! knows the others only by the bytes they send. Observations, logits and actions are
//! those of the environment's policy, step by step, so what was trained is what flies.

use covey_env::{ActorPolicy, PoiDistribution, Scenario, World};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Logits, Mode};
use firmware_core::agent::{Agent, AgentSettings};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, SPEED_CAP_U, State, TICKS_PER_U, Vec2};
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, MAX_AGE_STEPS, Moment};
use firmware_core::observation::{MAX_NEIGHBOURS, Observation};
use std::path::Path;

const SEED: u64 = 41;
/// A radio that reaches this far makes flight the same as training, u: whoever leaves
/// communication range is heard until no extrapolation of a last beacon (up to two
/// steps, each off by up to twice the speed cap) can bring it back.
const REACH_U: i32 = COMMUNICATION_RANGE_U + MAX_AGE_STEPS * 2 * SPEED_CAP_U;
/// A radio that reaches everyone.
const EVERYWHERE_U: i32 = 1000;
/// Sequence numbers and clock wrap around in the middle of an episode.
const FIRST_SEQUENCE: u16 = u16::MAX - 20;
const FIRST_TIME_MS: u32 = u32::MAX - 50_000;

fn committed(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-core/tests/data");
    std::fs::read(folder.join(format!("{name}.actor"))).expect("a committed sample actor")
}

/// A board: its agent, and what it measured and observed at the present step.
struct Board<'a> {
    agent: Agent,
    actor: Actor<'a>,
    own: State,
    now: Moment,
    observation: Observation,
}

impl<'a> Board<'a> {
    fn new(id: u16, actor: Actor<'a>, mode: Mode, half_side: i32) -> Self {
        let agent = Agent::new(AgentSettings { mode, half_side, ..AgentSettings::new(&actor, id, SEED) });
        Self { agent, actor, own: State::default(), now: Moment::default(), observation: [0; _] }
    }

    fn sequence(&self) -> u16 {
        FIRST_SEQUENCE.wrapping_add(self.now.step as u16)
    }

    /// A new step: measures the own state and tells it.
    fn beacon(&mut self, own: State, step: u32) -> Vec<u8> {
        let time_ms = FIRST_TIME_MS.wrapping_add(step * u32::from(DEFAULT_STEP_MS));
        (self.own, self.now) = (own, Moment { step, time_ms });
        bytes(&Message::Beacon(self.agent.beacon(self.now, self.sequence(), own)))
    }

    fn hear(&mut self, bytes: &[u8]) {
        let message = Message::decode(bytes).expect("what a board sends is a message");
        // Far senders may be turned away; the comparison below tells if a near one was.
        let _ = self.agent.hear(&message, self.own.position, self.now);
    }

    /// Observes, encodes and tells the feature, if the policy uses any.
    fn encode(&mut self, pois: &[Vec2]) -> Option<Vec<u8>> {
        self.observation = self.agent.observe(self.now, self.own, pois.iter().copied());
        let message = self.agent.encode(&self.actor, &self.observation, self.sequence()).expect("its own actor");
        message.map(|message| bytes(&Message::Feature(message)))
    }

    fn decide(&self) -> (Logits, Action) {
        let decision = self.agent.decide(&self.actor).expect("an encoded step");
        (decision.logits, decision.action)
    }
}

fn bytes(message: &Message) -> Vec<u8> {
    message.encode(&mut [0; MAX_LEN]).to_vec()
}

/// Delivers what everyone says to everyone whom the radio reaches, each in an order of
/// its own.
fn exchange(boards: &mut [Board<'_>], said: &[Option<Vec<u8>>], reach_u: i32) {
    let places: Vec<Vec2> = boards.iter().map(|b| b.own.position).collect();
    let n = boards.len();
    let square = |v: i32| i64::from(v).pow(2);
    for (i, board) in boards.iter_mut().enumerate() {
        for j in (0..n).map(|k| (2 * n - 1 - k + i) % n).filter(|&j| j != i) {
            let offset = places[j] - places[i];
            let near = square(offset.x) + square(offset.y) <= square(reach_u * TICKS_PER_U);
            if let (true, Some(bytes)) = (near, &said[j]) {
                board.hear(bytes);
            }
        }
    }
}

/// Flies an episode both ways and returns the greatest number of neighbours seen and the
/// number of neighbours in all decisions.
fn fly(file: &[u8], scenario: &Scenario, mode: Mode, reach_u: i32) -> (u8, usize) {
    let actor = Actor::load(file).expect("sound");
    actor.self_test().expect("sound");
    let mut world = World::new(scenario).expect("a scenario");
    world.reset(SEED, 3);
    let mut trained = ActorPolicy::new(actor, SEED, mode);
    let mut boards: Vec<_> =
        (0..scenario.uavs).map(|i| Board::new(i as u16, actor, mode, scenario.half_side_ticks())).collect();
    let pois: Vec<Vec2> = world.poi_x().iter().zip(world.poi_y()).map(|(&x, &y)| Vec2::from_u(x, y)).collect();
    let (mut most, mut heard) = (0, 0);
    while !world.done() {
        let step = world.steps_done();
        let state = |i: usize| {
            let ((x, y), (vx, vy)) = (world.position(i), world.velocity(i));
            State { position: Vec2::from_u(x, y), velocity: Vec2::from_u(vx, vy) }
        };
        let beacons: Vec<_> = boards.iter_mut().enumerate().map(|(i, b)| Some(b.beacon(state(i), step))).collect();
        exchange(&mut boards, &beacons, reach_u);
        let features: Vec<_> = boards.iter_mut().map(|b| b.encode(&pois)).collect();
        exchange(&mut boards, &features, reach_u);
        trained.observe(&world);
        let mut actions = Vec::new();
        for (i, board) in boards.iter().enumerate() {
            let (logits, action) = board.decide();
            let at = format!("step {step}, UAV {i}");
            assert_eq!(board.observation, trained.observations()[i], "{at}: observation");
            let ids: Vec<u16> = board.agent.neighbours().as_slice().iter().map(|n| n.id).collect();
            assert_eq!(ids, trained.neighbourhoods()[i].as_slice(), "{at}: neighbours");
            assert_eq!(logits, trained.logits(i), "{at}: logits");
            assert_eq!(action, trained.choose(&logits, i, step), "{at}: action");
            most = most.max(trained.neighbourhoods()[i].count);
            heard += ids.len();
            actions.push(action);
        }
        world.step(&actions);
    }
    (most, heard)
}

const KINDS: [&str; 5] = ["sample-none", "sample-gcn", "sample-gat", "sample-gatv2", "sample-sage"];

#[test]
fn the_papers_swarm_flies_as_it_was_trained() {
    for name in KINDS {
        for mode in [Mode::Sample, Mode::Argmax] {
            let (_, heard) = fly(&committed(name), &Scenario::default(), mode, REACH_U);
            assert!(heard > 100, "{name}: only {heard} neighbours in the episode");
        }
    }
}

/// More UAVs in reach than a table holds.
#[test]
fn a_dense_swarm_flies_as_it_was_trained() {
    let scenario = Scenario { uavs: 70, pois: 60, side_u: 80.0, steps: 60, distribution: PoiDistribution::Uniform };
    for name in KINDS {
        for reach_u in [REACH_U, EVERYWHERE_U] {
            let (most, _) = fly(&committed(name), &scenario, Mode::Sample, reach_u);
            assert_eq!(usize::from(most), MAX_NEIGHBOURS, "{name}: never a full table");
        }
    }
}

#[test]
fn one_uav_alone_flies_as_it_was_trained() {
    for name in KINDS {
        let scenario = Scenario { uavs: 1, ..Scenario::default() };
        assert_eq!(fly(&committed(name), &scenario, Mode::Sample, EVERYWHERE_U), (0, 0));
    }
}
