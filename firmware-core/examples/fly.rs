//! One step of two UAVs, as their nodes would fly it: `fly ACTOR_FILE`.
//!
//! A node does these five things every step; only the radio and the autopilot are missing.

use firmware_core::actor::Actor;
use firmware_core::agent::{Agent, AgentSettings};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::Moment;
use firmware_core::observation::Observation;
use std::error::Error;

/// Policy seed: the same on every UAV of the swarm.
const SEED: u64 = 10;

struct Uav {
    agent: Agent,
    state: State,
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: fly ACTOR_FILE")?;
    let file = std::fs::read(path)?;
    let actor = Actor::load(&file)?;
    actor.self_test()?; // No flight without it.
    let mut uavs = [(1, 100.0, 100.0), (2, 112.0, 104.0)].map(|(id, x, y)| Uav {
        agent: Agent::new(AgentSettings::new(&actor, id, SEED)),
        state: State { position: Vec2::from_u(x, y), velocity: Vec2::default() },
    });
    let pois = [Vec2::from_u(97.0, 108.0), Vec2::from_u(104.0, 96.0), Vec2::from_u(118.0, 110.0)];
    let now = Moment { step: 0, time_ms: 0 };
    // One beacon and one feature a step: the step numbers them.
    let sequence = now.step as u16;

    // 1. Tell the others where each UAV is. 2. Hear the others.
    let beacons: Vec<_> = uavs.iter().map(|uav| Message::Beacon(uav.agent.beacon(now, sequence, uav.state))).collect();
    exchange(&mut uavs, &beacons, now);
    // 3. Observe, encode, and tell the others the feature. 4. Hear theirs.
    let mut features = Vec::new();
    for uav in &mut uavs {
        let observation: Observation = uav.agent.observe(now, uav.state, pois);
        features.extend(uav.agent.encode(&actor, &observation, sequence)?.map(Message::Feature));
    }
    exchange(&mut uavs, &features, now);
    // 5. Decide.
    for uav in &uavs {
        let decision = uav.agent.decide(&actor)?;
        let (id, action) = (uav.agent.settings().id, decision.action);
        println!("UAV {id}: action {}, {:?} u/step²", action.index(), action.acceleration());
    }
    Ok(())
}

/// A radio that everyone hears, the sender too: its table drops what carries its own id.
fn exchange(uavs: &mut [Uav], messages: &[Message], now: Moment) {
    for message in messages {
        let mut buffer = [0; MAX_LEN];
        let bytes = message.encode(&mut buffer);
        for Uav { agent, state } in &mut *uavs {
            let id = agent.settings().id;
            match Message::decode(bytes) {
                Ok(message) => println!("UAV {id} hears: {:?}", agent.hear(&message, state.position, now)),
                Err(error) => println!("UAV {id} drops a message: {error}"),
            }
        }
    }
}
