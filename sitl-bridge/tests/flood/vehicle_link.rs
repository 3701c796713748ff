//! A running node, its own sockets and thread, against a scripted vehicle, with somebody else on both links.

use crate::flight::{mission, settings};
use crate::vehicle::Vehicle;
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::Firmware;
use sitl_bridge::connection::{Address, Connection};
use sitl_bridge::frame::{Reader, Source};
use sitl_bridge::node::run::{Links, NodeEvent, RunControl, run};
use sitl_bridge::node::{Counters, Node};
use sitl_bridge::signing::Session;
use sitl_bridge::swarm_link::{SwarmAddress, SwarmSocket};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// A setpoint that does not come in this time does not come at all.
const LOST: Duration = Duration::from_secs(20);
/// Length of the garbage's datagrams, bytes.
const GARBAGE: usize = 60;

/// The vehicle's end of the link.
pub struct VehicleLink {
    pub vehicle: Vehicle,
    /// Where the node listens: autopilot and swarm.
    pub node: [SocketAddr; 2],
    socket: UdpSocket,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Counters>,
}

impl VehicleLink {
    /// Starts a node and lets it bring its vehicle into flight and decide.
    pub fn launch() -> Self {
        let local = Ipv4Addr::LOCALHOST;
        let mission = mission();
        let autopilot = Connection::open(&Address::UdpIn { host: local.to_string(), port: 0 }).unwrap();
        let swarm = SwarmAddress::Peers { listen: (local, 0).into(), peers: Vec::new() };
        let swarm = SwarmSocket::open(&swarm).unwrap();
        let node = [(local, autopilot.listens_on().unwrap().port()).into(), swarm.listens_on()];
        let links = Links { autopilot, swarm: Some(swarm), tlog: None };
        let stop = Arc::new(AtomicBool::new(false));
        let control = RunControl::new(Arc::clone(&stop), false);
        let settings = settings(5, &mission, true);
        let thread = thread::spawn(move || {
            let (reports, received) = channel();
            let mut node = Node::new(settings, Session::new()).unwrap();
            run(&mut node, links, &control, 0, &reports).unwrap();
            let ended = received.try_iter().find_map(|(_, report)| match report {
                NodeEvent::Ended(counters) => Some(*counters),
                _ => None,
            });
            ended.unwrap()
        });
        let socket = UdpSocket::bind((local, 0)).unwrap();
        let vehicle = Vehicle::new(Firmware::ArduPilot, &mission, Vec2::from_u(100.0, 100.0));
        let mut link = Self { vehicle, node, socket, stop, thread };
        let began = Instant::now();
        while link.vehicle.speed() < 1.0 {
            assert!(began.elapsed() < LOST, "not in flight: {:?}", link.vehicle.commands);
            link.send_tick();
            // Commands are answered at the next tick.
            link.hear(Duration::from_millis(5));
        }
        link
    }

    /// Lets a tick pass, tells of it, and waits for its setpoint: how long that took.
    pub fn tick(&mut self) -> Duration {
        while self.hear(Duration::from_millis(1)) {}
        let before = self.vehicle.setpoints.len();
        self.send_tick();
        let sent = Instant::now();
        while self.vehicle.setpoints.len() == before {
            assert!(sent.elapsed() < LOST, "no setpoint");
            self.hear(Duration::from_millis(100));
        }
        sent.elapsed()
    }

    /// Ends the node; its counts.
    pub fn end(self) -> Counters {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }

    fn send_tick(&mut self) {
        for frame in self.vehicle.tick() {
            self.socket.send_to(frame.bytes(), self.node[0]).unwrap();
        }
    }

    /// Takes in a datagram of the node, waiting so long; whether there was one.
    fn hear(&mut self, wait: Duration) -> bool {
        self.socket.set_read_timeout(Some(wait)).unwrap();
        let mut buffer = [0; 512];
        let Ok(len) = self.socket.recv(&mut buffer) else { return false };
        let mut reader = Reader::new(Source::Datagrams);
        reader.push(&buffer[..len]);
        while let Some(frame) = reader.next_frame() {
            self.vehicle.hear(&frame);
        }
        true
    }
}

/// The n-th datagram of garbage: noise, with the beginning of a frame now and then.
pub fn garbage(n: u64) -> [u8; GARBAGE] {
    let mut state = n.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut bytes = [0; GARBAGE].map(|_: u8| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state.to_le_bytes()[3]
    });
    if n.is_multiple_of(2) {
        bytes[0] = 0xfd;
    }
    bytes
}
