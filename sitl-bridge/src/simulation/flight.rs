//! The flight of one world: its nodes and their links, the fleet, the comparison.

use super::comparison::compare;
use super::error::SimulationError;
use super::fleet::Fleet;
use super::fleet_config::{fleet_config, real_fleet_config};
use super::flight_driver::FlightDriver;
use super::run_folder::RunFolder;
use super::settings::{START_UNIX_MS, Simulation};
use super::world_flight::WorldFlight;
use crate::connection::{Address, Connection};
use crate::mission::{Mission, PoiMap};
use crate::node::run::{Links, NodeEvent, RunControl, run};
use crate::node::{FeedForward, Node, Pace, Settings, StepTiming, gate_limits};
use crate::outlet::say;
use crate::signing::Session;
use crate::swarm_link::{SwarmAddress, SwarmSocket};
use crate::tlog::TlogWriter;
use covey_env::World;
use covey_report::atomic;
use firmware_core::gate::Limits;
use std::fs;
use std::io;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::{SystemTime, UNIX_EPOCH};

/// Flies a world once; until all UAVs stream setpoints, the fleet runs at `bring_up_speed` times real
/// time.
pub(super) fn fly_world(
    sim: &Simulation<'_>,
    index: u64,
    world: &World,
    bring_up_speed: f64,
    stop: &Arc<AtomicBool>,
) -> Result<WorldFlight, SimulationError> {
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
    let epoch_ms = Arc::new(AtomicI64::new(RunControl::NO_EPOCH));
    let control = || {
        let (stop, epoch_ms) = (Arc::clone(&landed), Arc::clone(&epoch_ms));
        RunControl { stop, land: false, brake: false, epoch_ms, commands: None }
    };
    let (events, received) = channel();
    thread::scope(|scope| {
        let threads: Vec<_> = nodes
            .iter_mut()
            .zip(links.drain(..))
            .enumerate()
            .map(|(id, (node, links))| {
                let (control, events) = (control(), events.clone());
                scope.spawn(move || run(node, links, &control, id, &events))
            })
            .collect();
        drop(events);
        // Whatever goes wrong, the threads must end.
        let flown = start_fleet(sim, index, world, &mission, &ports, bring_up_speed).and_then(|started| {
            let StartedFleet { fleet, start_ms, mut folder } = started;
            FlightDriver::new(sim, world, &mission, fleet, start_ms, &received, stop, &epoch_ms)
                .drive()
                .inspect_err(|_| told_where(folder.as_mut()))
        });
        landed.store(true, Ordering::Relaxed);
        for (id, thread) in threads.into_iter().enumerate() {
            let ended = thread.join().unwrap_or_else(|_| Err(io::Error::other("it panicked")));
            if let (Err(source), true) = (ended, flown.is_ok()) {
                return Err(SimulationError::Thread { id, source });
            }
        }
        let mut flight = flown?;
        for (_, event) in received.try_iter() {
            if let NodeEvent::Ended(counters) = event {
                flight.counters.add(&counters);
            }
        }
        flight.count_decisions();
        keep_mission(sim, index, &mission, epoch_ms.load(Ordering::Relaxed))?;
        compare(sim, index, world, &mut flight);
        Ok(flight)
    })
}

struct StartedFleet {
    fleet: Fleet,
    /// Its clock at the start, Unix time in ms.
    start_ms: i64,
    /// The files of real autopilots.
    folder: Option<RunFolder>,
}

fn start_fleet(
    sim: &Simulation<'_>,
    index: u64,
    world: &World,
    mission: &Mission,
    ports: &[u16],
    bring_up_speed: f64,
) -> Result<StartedFleet, SimulationError> {
    let package = sim.autopilots.package();
    if !sim.autopilots.is_real() {
        let config = fleet_config(sim, world, mission, ports, bring_up_speed);
        let fleet = Fleet::start(&sim.python, package, &config, sim.verbose)?;
        return Ok(StartedFleet { fleet, start_ms: START_UNIX_MS, folder: None });
    }
    let mut folder = RunFolder::create(index).map_err(SimulationError::Folder)?;
    let config = real_fleet_config(sim, world, mission, ports, folder.path());
    let start_ms = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_millis() as i64;
    let fleet =
        Fleet::start(&sim.python, package, &config, sim.verbose).inspect_err(|_| told_where(Some(&mut folder)))?;
    Ok(StartedFleet { fleet, start_ms, folder: Some(folder) })
}

/// Keeps the files of autopilots whose flight failed, and says where they are.
fn told_where(folder: Option<&mut RunFolder>) {
    if let Some(folder) = folder {
        say(&format!("the autopilots' files and output are kept in {}", folder.keep().display()));
    }
}

/// Writes the mission as it was flown beside the recordings, which can be replayed with it.
fn keep_mission(
    sim: &Simulation<'_>,
    index: u64,
    mission: &Mission,
    epoch_unix_ms: i64,
) -> Result<(), SimulationError> {
    let Some(folder) = &sim.tlogs else { return Ok(()) };
    let flown = Mission { epoch_unix_ms, ..mission.clone() };
    let text = flown.to_toml(&format!("World {index} of seed {}, as it was flown", sim.seed));
    Ok(atomic::write(folder.join(format!("world-{index}.toml")), text.as_bytes())?)
}

/// The recording of UAV `id` in world `index`.
fn recording(folder: &Path, index: u64, id: usize) -> PathBuf {
    folder.join(format!("world-{index}-uav-{id}.tlog"))
}

/// Renames the recordings of a flight that did not begin, so that the next try has files of its own.
pub(super) fn set_recordings_aside(sim: &Simulation<'_>, index: u64) -> Result<(), SimulationError> {
    let Some(folder) = &sim.tlogs else { return Ok(()) };
    for id in 0..sim.scenario.uavs {
        let path = recording(folder, index, id);
        if path.exists() {
            fs::rename(&path, path.with_extension("aborted.tlog"))
                .map_err(|source| SimulationError::Recording { path, source })?;
        }
    }
    Ok(())
}

fn open_links(sim: &Simulation<'_>, index: u64, uavs: usize) -> Result<Vec<Links>, SimulationError> {
    let local = Ipv4Addr::LOCALHOST;
    let mut links = Vec::with_capacity(uavs);
    for id in 0..uavs {
        let autopilot = Connection::open(&Address::UdpIn { host: local.to_string(), port: 0 })?;
        let listen = (local, 0).into();
        let swarm = SwarmSocket::open(&SwarmAddress::Peers { listen, peers: Vec::new() })?;
        let tlog = sim.tlogs.as_ref().map(|folder| {
            let path = recording(folder, index, id);
            TlogWriter::create(&path).map_err(|source| SimulationError::Recording { path, source })
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
        pois: Arc::clone(pois),
        timing: StepTiming {
            pace: if sim.speed.is_none() && !sim.autopilots.is_real() { Pace::LockStep } else { Pace::Heard },
            // The scenario's own dynamics are behind nothing.
            lead_ms: if sim.ideal { 0 } else { sim.timing.lead_ms },
            ..sim.timing
        },
        limits,
        feed_forward: if sim.ideal { FeedForward::Action } else { FeedForward::Ramp },
        take_off: true,
        rate_hz: f64::from(sim.rate_hz),
        source: links.autopilot.source(),
        autopilot_signing: sim.signing.0.clone(),
        swarm_signing: sim.signing.1.clone(),
        record: links.tlog.is_some(),
        advice: links.autopilot.advice(),
        ..Settings::new(id, sim.actor, Arc::clone(mission))
    }
}
