//! How long a node takes for a setpoint, or a decision, while strangers send 10,000 datagrams of garbage a second to
//! each of its links: `cargo run --release -p sitl-bridge --example flood`.

#[path = "../tests/node/flight.rs"]
#[allow(dead_code)]
mod flight;
#[path = "../tests/node/mission.rs"]
#[allow(dead_code)]
mod mission;
#[path = "../tests/node/vehicle.rs"]
#[allow(dead_code)]
mod vehicle;
#[path = "../tests/flood/vehicle_link.rs"]
mod vehicle_link;

use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use vehicle_link::{VehicleLink, garbage};

/// Datagrams a second to each link.
const RATE: u64 = 10_000;
const LENGTH: Duration = Duration::from_secs(10);
/// Between two positions: more often than in flight, for more figures.
const TICK: Duration = Duration::from_millis(20);
/// Longest that a decision may be delayed.
const LIMIT: Duration = Duration::from_millis(50);

fn main() {
    let quiet = measure(0);
    let flooded = measure(RATE);
    assert!(flooded <= LIMIT, "a setpoint came after {flooded:?}; without garbage {quiet:?}");
}

/// The longest time from a position to its setpoint.
fn measure(rate: u64) -> Duration {
    let mut link = VehicleLink::launch();
    let stop = Arc::new(AtomicBool::new(false));
    let (ended, node) = (Arc::clone(&stop), link.node);
    let flood = thread::spawn(move || flood(rate, node, &ended));
    let (began, mut delays) = (Instant::now(), Vec::new());
    while began.elapsed() < LENGTH {
        let tick = Instant::now();
        delays.push(link.tick());
        thread::sleep(TICK.saturating_sub(tick.elapsed()));
    }
    stop.store(true, Ordering::Relaxed);
    let sent = flood.join().expect("no panic");
    let counters = link.end();
    delays.sort();
    let at = |share: f64| delays[((delays.len() - 1) as f64 * share) as usize].as_secs_f64() * 1000.0;
    let read: u64 = counters.rejected.values().sum();
    println!(
        "{:.0} datagrams/s to each link ({read} read as garbage): {} positions answered after {:.2} ms (median), \
         {:.2} ms (99 %), {:.2} ms (longest); {} decisions, {} late, {} missed",
        sent as f64 / LENGTH.as_secs_f64(),
        delays.len(),
        at(0.5),
        at(0.99),
        at(1.0),
        counters.decisions,
        counters.late_decisions,
        counters.missed_decisions,
    );
    delays[delays.len() - 1]
}

/// Sends so many a second to each link until told to stop; how many went to each.
fn flood(rate: u64, node: [std::net::SocketAddr; 2], stop: &AtomicBool) -> u64 {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let (began, mut sent) = (Instant::now(), 0);
    while !stop.load(Ordering::Relaxed) {
        let due = (began.elapsed().as_secs_f64() * rate as f64) as u64;
        while sent < due {
            let bytes = garbage(sent);
            // A full queue drops it.
            let _ = node.map(|to| socket.send_to(&bytes, to));
            sent += 1;
        }
        thread::sleep(Duration::from_millis(1));
    }
    sent
}
