//! Garbage on both links keeps a node from nothing. `examples/flood.rs` measures how long it takes.

#[path = "../node/flight.rs"]
#[allow(dead_code)]
mod flight;
#[path = "../node/mission.rs"]
mod mission;
#[path = "../node/vehicle.rs"]
#[allow(dead_code)]
mod vehicle;
mod vehicle_link;

use std::net::UdpSocket;
use vehicle_link::{VehicleLink, garbage};

/// Before each tick of 0.2 s: 10,000 datagrams a second on the swarm's link …
const TO_SWARM: u64 = 2000;
/// … and on the autopilot's as many as its queue surely holds besides the telemetry.
const TO_AUTOPILOT: u64 = 60;
const TICKS: u64 = 100;

#[test]
fn valid_telemetry_behind_garbage_is_used_at_once() {
    let mut link = VehicleLink::launch();
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    for tick in 0..TICKS {
        for n in 0..TO_SWARM {
            stranger.send_to(&garbage(tick * TO_SWARM + n), link.node[1]).unwrap();
        }
        for n in 0..TO_AUTOPILOT {
            stranger.send_to(&garbage(tick * TO_AUTOPILOT + n), link.node[0]).unwrap();
        }
        // Answered, before another position is there.
        link.tick();
    }
    let counters = link.end();
    assert!(counters.decisions >= TICKS / 10, "{counters:?}");
    assert_eq!((counters.late_decisions, counters.missed_decisions), (0, 0));
    let rejected: u64 = counters.rejected.values().sum();
    assert!(rejected >= TICKS * TO_AUTOPILOT, "the garbage was not read: {counters:?}");
}
