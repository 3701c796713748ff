//! One world: nodes, fleet, the wait for everybody, 100 steps, the account.

use super::account::account;
use super::director::Director;
use super::fleet::Fleet;
use super::{SimError, Simulation};
use crate::connection::{Address, Connection};
use crate::mission::{Mission, PoiMap};
use crate::node::run::{Control, Links, Report, run};
use crate::node::{Counters, Decision, FeedForward, Node, Settings, gate_limits};
use crate::signing::Session;
use crate::swarm_link::{SwarmAddress, SwarmSocket, system_of};
use crate::tlog::TlogWriter;
use covey_env::{EpisodeMetrics, World};
use covey_report::atomic;
use firmware_core::gate::Limits;
use firmware_core::geometry::State;
use serde_json::{Value, json};
use std::io;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::channel;
use std::thread;

/// The fleet's clock begins here, so that every run is the same: 2026-11-22, Unix time in ms.
pub(super) const START_UNIX_MS: i64 = 1_795_305_600_000;

/// What became of a world.
#[derive(Clone, Debug, Default)]
pub struct WorldFlight {
    /// States of all UAVs at the beginning of each step, 0 to the last and one beyond it; `None`
    /// where a UAV's telemetry missed the step.
    pub states: Vec<Vec<Option<State>>>,
    /// Decisions by step and UAV.
    pub decisions: Vec<Vec<Option<Decision>>>,
    /// Share of PoIs covered after each step, by the nodes' telemetry.
    pub coverage: Vec<f64>,
    /// The same, by where the fleet knows its vehicles to be.
    pub true_coverage: Vec<f64>,
    /// The same in the trainer's flight.
    pub trainer_coverage: Vec<f64>,
    /// All metrics of the trainer's flight.
    pub trainer: EpisodeMetrics,
    /// Decisions that are the trainer's: with ideal dynamics those of its own flight, else
    /// those it would make in the situation that was measured.
    pub equal: u64,
    /// Decisions that could be compared.
    pub compared: u64,
    /// The first decision that is not the trainer's, in words.
    pub first_difference: Option<String>,
    /// Counts of all nodes.
    pub counters: Counters,
    /// Simulated and host's seconds of the steps.
    pub simulated_s: f64,
    /// See `simulated_s`.
    pub wall_s: f64,
    /// Host's seconds before the first step.
    pub bring_up_s: f64,
    /// Events of the fleet that tell of trouble: time-outs, failsafes, crashes.
    pub trouble: Vec<Value>,
}

/// Flies a world once; until everybody streams, the fleet moves at `bring_up_speed` times real time.
pub(super) fn fly(
    sim: &Simulation<'_>,
    index: u64,
    world: &World,
    bring_up_speed: f64,
    stop: &Arc<AtomicBool>,
) -> Result<WorldFlight, SimError> {
    let mission = Arc::new(sim.mission(world, index)?);
    let uavs = sim.scenario.uavs;
    let mut links = open_links(sim, index, uavs)?;
    let ports: Vec<u16> = links.iter().map(|l| l.autopilot.listens_on().map_or(0, |address| address.port())).collect();
    let pois = Arc::new(PoiMap::new(&mission.pois));
    let mut nodes = Vec::with_capacity(uavs);
    for (id, link) in links.iter().enumerate() {
        let mut node = Node::new(settings(sim, id as u16, &mission, &pois, link), Session::new())?;
        if let Some(sequence) = sim.sequence {
            node.set_sequence(sequence);
        }
        nodes.push(node);
    }
    let landed = Arc::new(AtomicBool::new(false));
    let epoch_ms = Arc::new(AtomicI64::new(Control::NO_EPOCH));
    let control = || {
        let (stop, epoch_ms) = (Arc::clone(&landed), Arc::clone(&epoch_ms));
        Control { stop, land: false, epoch_ms, orders: None }
    };
    let (reports, received) = channel();
    thread::scope(|scope| {
        let threads: Vec<_> = nodes
            .iter_mut()
            .zip(links.drain(..))
            .enumerate()
            .map(|(id, (node, links))| {
                let (control, reports) = (control(), reports.clone());
                scope.spawn(move || run(node, links, &control, id, &reports))
            })
            .collect();
        drop(reports);
        // Whatever goes wrong, the threads must end.
        let flown = Fleet::start(&sim.python, &fleet_config(sim, world, &mission, &ports, bring_up_speed), sim.verbose)
            .map_err(SimError::from)
            .and_then(|fleet| Director::new(sim, world, &mission, fleet, &received, stop, &epoch_ms).direct());
        landed.store(true, Ordering::Relaxed);
        for (id, thread) in threads.into_iter().enumerate() {
            let ended = thread.join().unwrap_or_else(|_| Err(io::Error::other("it panicked")));
            if let (Err(source), true) = (ended, flown.is_ok()) {
                return Err(SimError::Thread { id, source });
            }
        }
        let mut flight = flown?;
        for (_, report) in received.try_iter() {
            if let Report::Ended(counters) = report {
                flight.counters.add(&counters);
            }
        }
        keep_mission(sim, index, &mission, epoch_ms.load(Ordering::Relaxed))?;
        account(sim, index, world, &mut flight);
        Ok(flight)
    })
}

/// Puts the mission as it was flown beside the recordings, which can be replayed with it.
fn keep_mission(sim: &Simulation<'_>, index: u64, mission: &Mission, epoch_unix_ms: i64) -> Result<(), SimError> {
    let Some(folder) = &sim.tlogs else { return Ok(()) };
    let flown = Mission { epoch_unix_ms, ..mission.clone() };
    let text = flown.to_toml(&format!("World {index} of seed {}, as it was flown", sim.seed));
    Ok(atomic::write(folder.join(format!("world-{index}.toml")), text.as_bytes())?)
}

fn open_links(sim: &Simulation<'_>, index: u64, uavs: usize) -> Result<Vec<Links>, SimError> {
    let local = Ipv4Addr::LOCALHOST;
    let mut links = Vec::with_capacity(uavs);
    for id in 0..uavs {
        let autopilot = Connection::open(&Address::UdpIn { host: local.to_string(), port: 0 })?;
        let listen = (local, 0).into();
        let swarm = SwarmSocket::open(&SwarmAddress::Peers { listen, peers: Vec::new() })?;
        let tlog = sim.tlogs.as_ref().map(|folder| {
            TlogWriter::create(&folder.join(format!("world-{index}-uav-{id}.tlog")))
                .map_err(|source| SimError::Thread { id, source })
        });
        links.push(Links { autopilot, swarm: Some(swarm), tlog: tlog.transpose()? });
    }
    let addresses: Vec<_> = links.iter().filter_map(|l| l.swarm.as_ref()).map(SwarmSocket::listens_on).collect();
    for link in &mut links {
        if let Some(swarm) = &mut link.swarm {
            let own = swarm.listens_on();
            let others: Vec<_> = addresses.iter().copied().filter(|&address| address != own).collect();
            swarm.set_peers(&others);
        }
    }
    Ok(links)
}

fn settings<'a>(
    sim: &Simulation<'a>,
    id: u16,
    mission: &Arc<Mission>,
    pois: &Arc<PoiMap>,
    links: &Links,
) -> Settings<'a> {
    let base = if sim.ideal { Limits::ideal() } else { Limits::simulation() };
    let limits = gate_limits(base, mission);
    Settings {
        id,
        system: system_of(id).unwrap_or(u8::MAX),
        actor: sim.actor,
        mission: Arc::clone(mission),
        pois: Arc::clone(pois),
        timing: sim.timing,
        limits,
        feed_forward: if sim.ideal { FeedForward::Action } else { FeedForward::Ramp },
        take_off: true,
        rate_hz: f64::from(sim.rate_hz),
        source: links.autopilot.source(),
        autopilot_signing: sim.signing.0.clone(),
        swarm_signing: sim.signing.1.clone(),
        record: links.tlog.is_some(),
        advice: links.autopilot.advice(),
    }
}

fn fleet_config(sim: &Simulation<'_>, world: &World, mission: &Mission, ports: &[u16], bring_up_speed: f64) -> Value {
    let (lat, lon) = mission.plane.origin_degrees();
    let alt = f64::from(mission.plane.alt_mm) / 1000.0;
    let dialect = if sim.px4 { "px4" } else { "ardupilot" };
    let vehicle = |(id, &port): (usize, &u16)| {
        let (x, y) = world.position(id);
        json!({"id": id, "system": id + 1, "host": "127.0.0.1", "port": port, "dialect": dialect, "start_u": [x, y]})
    };
    let mut config = json!({
        "vehicles": ports.iter().enumerate().map(vehicle).collect::<Vec<_>>(),
        "origin": {"lat": lat, "lon": lon, "alt": alt},
        "scale_m": mission.scale.unit_m,
        "step_ms": mission.scale.step_ms,
        "map_side_u": mission.side_u,
        // Not before it is told.
        "epoch_unix_ms": START_UNIX_MS + 1_000_000_000_000,
        "rate_hz": sim.rate_hz,
        "dynamics": if sim.ideal { "ideal" } else { "point" },
        "lockstep": sim.speed.is_none(),
        "speed": sim.speed.unwrap_or(bring_up_speed),
        "seed": sim.seed,
        "signing_key_file": sim.key_file,
        "unix_ms": START_UNIX_MS,
    });
    for (name, value) in &sim.fleet {
        config[name] = value.clone();
    }
    config
}
