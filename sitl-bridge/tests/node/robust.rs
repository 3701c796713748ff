//! Whatever an autopilot or a neighbour sends, a node goes on, and nothing that is no number or
//! beyond the limits leaves it (the scripted vehicle checks every setpoint).

use crate::flight::{Flight, actor, mission};
use firmware_core::actor::MAX_FEATURE;
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, Message};
use proptest::prelude::*;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::frame::{Encoder, Frame};
use sitl_bridge::signing::{LinkSigning, Session, Timestamp};
use sitl_bridge::swarm_link::SwarmLink;

/// Messages that a node reads.
const IDS: [u32; 13] = [0, 1, 2, 24, 32, 33, 49, 77, 147, 193, 230, 245, 253];

#[derive(Clone, Debug)]
enum Event {
    /// A message of the autopilot with any content.
    Odd { id: usize, payload: Vec<u8> },
    /// A position whose time is right and whose other numbers are any.
    Place { fields: Vec<u32>, ahead_ms: u32 },
    /// A neighbour says anything.
    Neighbour { id: u16, sequence: u16, ahead: i8, place: (i32, i32), feature: bool, values: Vec<i8> },
    /// Time passes.
    Ticks(u8),
    /// Only the host's time passes.
    Idle(u16),
}

fn event() -> impl Strategy<Value = Event> {
    let numbers = prop_oneof![
        any::<u32>(),
        Just(0),
        Just(f32::NAN.to_bits()),
        Just(f32::INFINITY.to_bits()),
        Just(f32::MAX.to_bits()),
        Just(i32::MIN as u32),
        Just(i32::MAX as u32)
    ];
    prop_oneof![
        3 => (0..IDS.len(), prop::collection::vec(any::<u8>(), 0..60)).prop_map(|(id, payload)| Event::Odd { id, payload }),
        3 => (prop::collection::vec(numbers, 10), 0u32..600).prop_map(|(fields, ahead_ms)| Event::Place { fields, ahead_ms }),
        3 => (0u16..6, any::<u16>(), -3i8..4, any::<(i32, i32)>(), any::<bool>(), prop::collection::vec(any::<i8>(), 1..=MAX_FEATURE))
            .prop_map(|(id, sequence, ahead, place, feature, values)| Event::Neighbour { id, sequence, ahead, place, feature, values }),
        4 => (1u8..20).prop_map(Event::Ticks),
        1 => (0u16..3000).prop_map(Event::Idle),
    ]
}

fn neighbour(event: &Event, step: u32, common_ms: i64) -> Option<Frame> {
    let Event::Neighbour { id, sequence, ahead, place, feature, values } = event else { return None };
    let step = step.wrapping_add_signed(i32::from(*ahead));
    let header = Header { id: *id, sequence: *sequence, step };
    let message = if *feature {
        Message::Feature(FeatureMessage::new(header, 2, actor().message_hash(), 0, values).ok()?)
    } else {
        let state =
            State { position: Vec2::from_ticks(place.0, place.1), velocity: Vec2::from_ticks(place.1, place.0) };
        Message::Beacon(Beacon::new(header, (common_ms + i64::from(*ahead) * 2000) as u32, state, 3))
    };
    let mut link = SwarmLink::new(*id, LinkSigning::off()).ok()?;
    link.wrap(&message, &mut Session::new(), Timestamp::default()).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn nothing_that_comes_in_stops_a_node(
        events in prop::collection::vec(event(), 1..60), px4: bool, at_once: bool, take_off: bool,
    ) {
        let firmware = if px4 { Firmware::Px4 } else { Firmware::ArduPilot };
        let mut flight = Flight::new(1, firmware, take_off);
        if !at_once {
            flight.until(60, |f| f.node.stage() == Stage::Flying);
        }
        let mut encoder = Encoder::new(7, 1);
        for event in &events {
            match event {
                Event::Odd { id, payload } => {
                    flight.hear_autopilot(&encoder.encode_payload(IDS[*id], payload).unwrap());
                }
                Event::Place { fields, ahead_ms } => {
                    let boot_ms = flight.vehicle.boot_ms.wrapping_add(*ahead_ms).to_le_bytes();
                    // Near the mission, or nothing else of it would count.
                    let (lat, lon) = mission().plane.degrees_e7(flight.vehicle.place);
                    let (global, local) = fields.split_at(4);
                    let global: Vec<u8> = global.iter().flat_map(|field| field.to_le_bytes()).collect();
                    let global = [&boot_ms[..], &lat.to_le_bytes(), &lon.to_le_bytes(), &global].concat();
                    flight.hear_autopilot(&encoder.encode_payload(33, &global).unwrap());
                    let local: Vec<u8> = local.iter().flat_map(|field| field.to_le_bytes()).collect();
                    let local = [&boot_ms[..], &local].concat();
                    flight.hear_autopilot(&encoder.encode_payload(32, &local).unwrap());
                }
                Event::Neighbour { .. } => {
                    let common_ms = flight.node.common_ms().unwrap_or(0);
                    let step = flight.begun.last().map_or(0, |begun| begun.step);
                    if let Some(frame) = neighbour(event, step, common_ms) {
                        flight.hear_swarm(&frame);
                    }
                }
                Event::Ticks(n) => flight.ticks(u32::from(*n)),
                Event::Idle(ms) => drop(flight.idle(u64::from(*ms))),
            }
            prop_assert!(!flight.node.status(flight.now()).mode.is_empty());
        }
        flight.ticks(5);
        let counters = flight.node.counters();
        prop_assert!(counters.limited_setpoints <= counters.setpoints);
    }
}
