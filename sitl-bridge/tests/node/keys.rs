//! Keys that do not fit: what a node says of them.

use crate::flight::{Flight, mission, settings};
use crate::vehicle::Vehicle;
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::Firmware;
use sitl_bridge::frame::Frame;
use sitl_bridge::node::Settings;
use sitl_bridge::signing::{Key, LinkSigning, Session, Timestamp, Unsigned};

fn key(byte: u8) -> LinkSigning {
    LinkSigning::new(Key::new([byte; 32]), 0, Unsigned::Refuse)
}

fn place() -> Vec2 {
    Vec2::from_u(100.0, 100.0)
}

fn told(flight: &Flight, text: &str) -> Vec<String> {
    flight.words().iter().filter(|words| words.contains(text)).map(|words| (*words).into()).collect()
}

/// Ten seconds of a vehicle whose frames are signed like this.
fn hear(flight: &mut Flight, sign: impl Fn(&mut Session, Frame, Timestamp) -> Frame) {
    let (mut vehicle, mut session) = (Vehicle::new(Firmware::ArduPilot, &mission(), place()), Session::new());
    for _ in 0..50 {
        let now = Timestamp::from_unix_us(flight.now().unix_us);
        let frames: Vec<_> = vehicle.tick().into_iter().map(|frame| sign(&mut session, frame, now)).collect();
        flight.hear_all(&frames);
    }
}

#[test]
fn an_autopilot_with_another_key_or_none_is_told_at_once_and_then_summed_up() {
    let settings = Settings { autopilot_signing: key(1), ..settings(5, &mission(), true) };
    let mut flight = Flight::with(settings, Firmware::ArduPilot, place());
    hear(&mut flight, |session, frame, now| session.sign(&key(2), frame, now).unwrap());
    let words = told(&flight, "signs with another key");
    assert!(words.len() == 1 && words[0].contains("(8 frames refused)"), "{words:?}");
    hear(&mut flight, |_, frame, _| frame);
    assert_eq!(told(&flight, "the autopilot does not sign").len(), 1);
    // After half a minute come those that were not told yet.
    flight.wall_ms += 30_000;
    flight.idle(0);
    let words = told(&flight, "signs with another key");
    assert!(words.len() == 2 && words[1].contains("more frames refused"), "{words:?}");
    hear(&mut flight, |session, frame, now| {
        session.sign(&key(1), frame, now.before(std::time::Duration::from_secs(600))).unwrap()
    });
    assert_eq!(told(&flight, "more than a minute old").len(), 1, "{:?}", flight.words());
}

#[test]
fn an_autopilot_that_signs_to_a_node_without_a_key_is_told() {
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    hear(&mut flight, |session, frame, now| session.sign(&key(2), frame, now).unwrap());
    assert_eq!(told(&flight, "this node has no key").len(), 1, "{:?}", flight.words());
}
