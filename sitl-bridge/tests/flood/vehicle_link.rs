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

/// A vehicle that is not in flight by then never will be, seconds of its own time.
const BRING_UP_S: u32 = 300;
/// Ticks in a second of the vehicle's time.
const TICKS_A_SECOND: u32 = 5;
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
        let mut seconds = 0;
        while link.vehicle.speed() < 1.0 {
            assert!(seconds < BRING_UP_S, "not in flight: {:?}", link.vehicle.commands);
            if link.vehicle.setpoints.is_empty() {
                link.second();
            } else {
                for _ in 0..TICKS_A_SECOND {
                    link.tick();
                }
            }
            seconds += 1;
        }
        link
    }

    /// Lets a tick pass, tells of it, and waits for its setpoint: how long that took.
    pub fn tick(&mut self) -> Duration {
        self.send_tick();
        let sent = Instant::now();
        while !self.is_answered() {
            self.hear();
        }
        sent.elapsed()
    }

    /// Whether a setpoint has answered what the vehicle told last.
    fn is_answered(&self) -> bool {
        self.vehicle.setpoints.last().is_some_and(|setpoint| setpoint.boot_ms == self.vehicle.boot_ms)
    }

    /// Lets a second of the vehicle's time pass. The node sends one HEARTBEAT in it, which is waited for.
    fn second(&mut self) {
        let before = self.vehicle.heartbeats;
        (0..TICKS_A_SECOND).for_each(|_| self.send_tick());
        while self.vehicle.heartbeats == before {
            self.hear();
        }
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

    /// Takes in the node's next datagram, whenever it comes.
    fn hear(&mut self) {
        let mut buffer = [0; 512];
        let len = self.socket.recv(&mut buffer).unwrap();
        let mut reader = Reader::new(Source::Datagrams);
        reader.push(&buffer[..len]);
        while let Some(frame) = reader.next_frame() {
            self.vehicle.hear(&frame);
        }
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
