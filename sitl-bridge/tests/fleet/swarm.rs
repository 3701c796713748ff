//! Nodes in flight against the simulated autopilots: each a thread with its own sockets.

use firmware_core::actor::Actor;
use firmware_core::gate::Limits;
use serde_json::{Map, Value, json};
use sitl_bridge::connection::{Address, Connection};
use sitl_bridge::mission::{Mission, PoiMap};
use sitl_bridge::node::run::{Links, NodeEvent, RunControl, run};
use sitl_bridge::node::{Counters, FeedForward, Node, Settings, StepTiming, gate_limits};
use sitl_bridge::signing::{LinkSigning, Session};
use sitl_bridge::simulation::{Fleet, find_python};
use sitl_bridge::swarm_link::{SwarmAddress, SwarmSocket, system_of};
use std::io;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread::{self, JoinHandle};

/// The actor that comes with Covey.
const ACTOR: &[u8] = include_bytes!("../../../host-trainer/actors/gcn.postcard");

/// What is flown.
pub struct Plan {
    /// The mission of all.
    pub mission: Mission,
    /// Pads on the map, u, one a UAV.
    pub pads: Vec<[f64; 2]>,
    /// First sequence number of neighbour messages.
    pub sequence: Option<u16>,
    /// The gate's settings.
    pub limits: Limits,
    /// Set over the fleet's configuration.
    pub fleet: Map<String, Value>,
}

/// Nodes and fleet in flight.
pub struct Swarm {
    /// The simulated autopilots.
    pub fleet: Fleet,
    /// What the nodes report.
    pub reports: Receiver<(usize, NodeEvent)>,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<io::Result<()>>>,
}

impl Swarm {
    /// Starts both. UAV i flies from pad i as vehicle i, and takes off by itself.
    pub fn launch(plan: &Plan) -> Self {
        let actor = Actor::load(ACTOR).expect("sound");
        actor.self_test().expect("computed here as by its exporter");
        let mission = Arc::new(plan.mission.clone());
        let pois = Arc::new(PoiMap::new(&mission.pois));
        let links = open_links(plan.pads.len());
        let ports: Vec<u16> = links.iter().map(|l| l.autopilot.listens_on().expect("udp").port()).collect();
        let stop = Arc::new(AtomicBool::new(false));
        let (send, reports) = channel();
        let threads = (0u16..)
            .zip(links)
            .map(|(id, links)| {
                let settings = Settings {
                    id,
                    // The ground station's, so that the autopilots' failsafe watches the nodes.
                    system: 255,
                    vehicle_system: system_of(id).expect("few"),
                    actor,
                    mission: Arc::clone(&mission),
                    pois: Arc::clone(&pois),
                    timing: StepTiming::default(),
                    limits: gate_limits(plan.limits, &mission),
                    feed_forward: FeedForward::Ramp,
                    take_off: true,
                    wait_for: 1,
                    strict: false,
                    rate_hz: 5.0,
                    source: links.autopilot.source(),
                    autopilot_signing: LinkSigning::off(),
                    swarm_signing: LinkSigning::off(),
                    record: false,
                    advice: links.autopilot.advice(),
                };
                let mut node = Node::new(settings, Session::new()).expect("a sound mission");
                if let Some(sequence) = plan.sequence {
                    node.set_sequence(sequence);
                }
                // The fleet ends with the flight: while some nodes braked, the others' silence would be a failsafe.
                let control = RunControl { brake: false, ..RunControl::new(Arc::clone(&stop), false) };
                let send = send.clone();
                thread::spawn(move || run(&mut node, links, &control, usize::from(id), &send))
            })
            .collect();
        let fleet = Fleet::start(&find_python(None), "simlink", &fleet_config(plan, &ports), false);
        let fleet = fleet.unwrap_or_else(|error| panic!("{error}"));
        Self { fleet, reports, stop, threads }
    }

    /// Ends all; returns the counts of each node, in the order of their ids, and the fleet's last events.
    pub fn end(mut self) -> (Vec<Counters>, Vec<Value>) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            thread.join().expect("no panic").expect("links that can be waited on");
        }
        let mut counters = Vec::new();
        let mut ended: Vec<_> = self.reports.try_iter().collect();
        ended.sort_by_key(|&(id, _)| id);
        for (_, report) in ended {
            if let NodeEvent::Ended(last) = report {
                counters.push(*last);
            }
        }
        (counters, self.fleet.stop())
    }
}

fn open_links(uavs: usize) -> Vec<Links> {
    let local = Ipv4Addr::LOCALHOST;
    let address = Address::UdpIn { host: local.to_string(), port: 0 };
    let listen = SwarmAddress::Peers { listen: (local, 0).into(), peers: Vec::new() };
    let swarm: Vec<_> = (0..uavs).map(|_| SwarmSocket::open(&listen).expect("a port")).collect();
    let all: Vec<_> = swarm.iter().map(SwarmSocket::listens_on).collect();
    let one = |(own, mut swarm): (usize, SwarmSocket)| {
        let mut peers = all.clone();
        peers.remove(own);
        swarm.set_peers(&peers);
        Links { autopilot: Connection::open(&address).expect("a port"), swarm: Some(swarm), tlog: None }
    };
    swarm.into_iter().enumerate().map(one).collect()
}

fn fleet_config(plan: &Plan, ports: &[u16]) -> Value {
    let (lat, lon) = plan.mission.plane.origin_degrees();
    let vehicle = |(id, (port, pad)): (usize, (&u16, &[f64; 2]))| json!({"id": id, "system": id + 1, "port": port, "start_u": pad});
    let mut config = json!({
        "vehicles": ports.iter().zip(&plan.pads).enumerate().map(vehicle).collect::<Vec<_>>(),
        "origin": {"lat": lat, "lon": lon, "alt": f64::from(plan.mission.plane.alt_mm) / 1000.0},
        "scale_m": plan.mission.scale.unit_m,
        "step_ms": plan.mission.scale.step_ms,
        "map_side_u": plan.mission.side_u,
        "epoch_unix_ms": plan.mission.epoch_unix_ms,
        "parameters": {"FS_GCS_ENABLE": 1},
        // A busy computer is no fault.
        "lockstep_timeout_s": 10,
    });
    for (name, value) in &plan.fleet {
        config[name] = value.clone();
    }
    config
}
