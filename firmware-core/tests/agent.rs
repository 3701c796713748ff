//! The steps of an agent, through its public interface alone.

mod common;

use common::{cells_actor, sample_actor};
use firmware_core::actor::{Actor, Aggregation, CellsActor, Mode};
use firmware_core::agent::{Agent, AgentError, AgentSettings};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{Beacon, MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, MessageOutcome, Moment};
use firmware_core::observation::cells::Cells;
use firmware_core::observation::{Neighbour, Neighbours, Observation, Scene, observe};

const SEED: u64 = 10;

fn state(x: f32, y: f32) -> State {
    State { position: Vec2::from_u(x, y), velocity: Vec2::from_u(1.0, -0.5) }
}

const fn at(step: u32) -> Moment {
    Moment { step, time_ms: step * DEFAULT_STEP_MS as u32 }
}

const POIS: [Vec2; 2] = [Vec2 { x: 99 << 10, y: 101 << 10 }, Vec2 { x: 108 << 10, y: 97 << 10 }];

/// What a receiver makes of the bytes of a message.
fn over_the_air(message: Message) -> Message {
    Message::decode(message.encode(&mut [0; MAX_LEN])).unwrap()
}

/// Two UAVs, 8 u apart, fly a step; what the first one decided.
fn fly(actor: &Actor<'_>, agents: &mut [Agent; 2], now: Moment) -> firmware_core::agent::Decision {
    let states = [state(100.0, 100.0), state(108.0, 100.0)];
    for (from, to) in [(0, 1), (1, 0)] {
        let beacon = over_the_air(Message::Beacon(agents[from].beacon(now, now.step as u16, states[from])));
        let _ = agents[to].hear(&beacon, states[to].position, now);
    }
    let features = [0, 1].map(|i| {
        let observation: Observation = agents[i].observe(now, states[i], POIS);
        agents[i].encode(actor, &observation, now.step as u16).unwrap()
    });
    for (from, to) in [(0, 1), (1, 0)] {
        if let Some(feature) = features[from].clone() {
            let answer = agents[to].hear(&over_the_air(Message::Feature(feature)), states[to].position, now);
            assert!(answer.is_taken(), "{answer:?}");
        }
    }
    agents[0].decide(actor).unwrap()
}

#[test]
fn a_step_is_what_its_parts_make_of_it() {
    for aggregation in Aggregation::ALL {
        let file = sample_actor(aggregation, 3);
        let actor = Actor::load(&file).unwrap();
        let mut agents = [7, 9].map(|id| Agent::new(AgentSettings::new(&actor, id, SEED)));
        let decision = fly(&actor, &mut agents, at(5));

        let (a, b) = (state(100.0, 100.0), state(108.0, 100.0));
        let ties = [7, 9].map(|id| actor.tie_breaker(SEED, id, 5));
        let seen = |id, tie, own: State, from: State| {
            let mut neighbours = Neighbours::new();
            neighbours.insert(Neighbour { id, offset: own.position - from.position, velocity: own.velocity, tie });
            neighbours
        };
        let encoded = |id, tie, own, neighbours: &Neighbours| {
            actor.encode(&observe(&Scene { id, own, tie, half_side: 102_400, neighbours }, POIS))
        };
        let (of_a, of_b) = (seen(9, ties[1], b, a), seen(7, ties[0], a, b));
        let (own, other) = (encoded(7, ties[0], a, &of_a), encoded(9, ties[1], b, &of_b));
        let width = usize::from(actor.dimensions().feature);
        let neighbour = firmware_core::actor::NeighbourFeature {
            values: &other.values[..width],
            degree: 2,
            attention_source: other.attention_source,
        };
        let logits = actor.logits(&own, 2, (aggregation != Aggregation::None).then_some(neighbour));
        assert_eq!(agents[0].feature(), Some(&own));
        assert_eq!((decision.step, decision.logits), (5, logits), "{aggregation:?}");
        assert_eq!(decision.action, actor.choose(&logits, Mode::Sample, SEED, 7, 5));
        assert_eq!(decision.features, u8::from(aggregation != Aggregation::None));
        assert_eq!((agents[0].degree(), agents[0].known()), (2, 1));
        assert_eq!(agents[0].neighbours().as_slice(), of_a.as_slice());
    }
}

#[test]
fn messages_say_who_when_and_in_which_order() {
    let file = sample_actor(Aggregation::Gat, 3);
    let actor = Actor::load(&file).unwrap();
    let mut agent = Agent::new(AgentSettings::new(&actor, 7, SEED));
    let beacon = agent.beacon(at(5), 41, state(100.0, 100.0));
    assert_eq!((beacon.header().id, beacon.header().sequence, beacon.header().step), (7, 41, 5));
    assert_eq!((beacon.time_ms(), beacon.tie()), (10_000, agent.tie_breaker(5)));
    let observation: Observation = agent.observe(at(5), state(100.0, 100.0), POIS);
    let feature = agent.encode(&actor, &observation, 42).unwrap().unwrap();
    assert_eq!((feature.header().id, feature.header().sequence, feature.header().step), (7, 42, 5));
    assert_eq!((feature.degree(), feature.actor()), (1, actor.message_hash()));
}

#[test]
fn steps_come_in_order() {
    let file = sample_actor(Aggregation::Gcn, 3);
    let actor = Actor::load(&file).unwrap();
    let mut agent = Agent::new(AgentSettings::new(&actor, 7, SEED));
    assert_eq!(agent.decide(&actor), Err(AgentError::NotEncoded));
    assert_eq!(agent.encode(&actor, &[0; _], 0), Err(AgentError::NotObserved));
    let observation: Observation = agent.observe(at(5), state(100.0, 100.0), POIS);
    assert_eq!((agent.observed_step(), agent.decide(&actor)), (Some(5), Err(AgentError::NotEncoded)));
    agent.encode(&actor, &observation, 0).unwrap();
    assert_eq!(agent.decide(&actor).unwrap().step, 5);
    // The feature of a step is none of the next.
    let _: Observation = agent.observe(at(6), state(100.0, 100.0), POIS);
    assert_eq!((agent.feature(), agent.decide(&actor)), (None, Err(AgentError::NotEncoded)));
}

#[test]
fn another_actor_is_refused() {
    let (file, other) = (sample_actor(Aggregation::Gcn, 3), sample_actor(Aggregation::Gcn, 4));
    let (actor, other) = (Actor::load(&file).unwrap(), Actor::load(&other).unwrap());
    let mut agent = Agent::new(AgentSettings::new(&actor, 7, SEED));
    let observation: Observation = agent.observe(at(5), state(100.0, 100.0), POIS);
    assert_eq!(agent.encode(&other, &observation, 0), Err(AgentError::OtherActor));
    agent.encode(&actor, &observation, 0).unwrap();
    assert_eq!(agent.decide(&other), Err(AgentError::OtherActor));
}

#[test]
fn reset_forgets_everything() {
    let file = sample_actor(Aggregation::Gcn, 3);
    let actor = Actor::load(&file).unwrap();
    let settings = AgentSettings { mode: Mode::Argmax, ..AgentSettings::new(&actor, 7, SEED) };
    let mut agents = [settings, AgentSettings { id: 9, ..settings }].map(Agent::new);
    let first = fly(&actor, &mut agents, at(5));
    agents[0].reset(AgentSettings { id: 8, ..settings });
    assert_eq!((agents[0].known(), agents[0].degree(), agents[0].observed_step()), (0, 1, None));
    assert_eq!(agents[0].decide(&actor), Err(AgentError::NotEncoded));
    // As it was, it flies as it did.
    agents[0].reset(settings);
    agents[1].reset(AgentSettings { id: 9, ..settings });
    assert_eq!(fly(&actor, &mut agents, at(5)), first);
}

#[test]
fn its_own_messages_and_old_ones_are_not_heard() {
    let file = sample_actor(Aggregation::Gcn, 3);
    let actor = Actor::load(&file).unwrap();
    let mut agent = Agent::new(AgentSettings::new(&actor, 7, SEED));
    let own = Message::Beacon(agent.beacon(at(5), 5, state(100.0, 100.0)));
    assert_eq!(agent.hear(&own, Vec2::default(), at(5)), MessageOutcome::OwnId);
    let other = Agent::new(AgentSettings::new(&actor, 9, SEED));
    let late: Beacon = other.beacon(at(1), 1, state(100.0, 100.0));
    assert_eq!(agent.hear(&Message::Beacon(late), Vec2::default(), at(5)), MessageOutcome::Late);
}

#[test]
fn the_papers_observation_flies_too() {
    let file = cells_actor(Aggregation::Gcn, 4);
    let actor = CellsActor::load(&file).unwrap();
    let mut agent = Agent::new(AgentSettings::new(&actor, 7, SEED));
    let cells: Cells = agent.observe(at(5), state(100.0, 100.0), POIS);
    agent.encode(&actor, &cells, 5).unwrap();
    let logits = actor.logits(&actor.encode(&cells), 1, []);
    assert_eq!(agent.decide(&actor).unwrap().logits, logits);
}
