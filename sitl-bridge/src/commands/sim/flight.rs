//! One world: nodes, fleet, the wait for everybody, 100 steps, the account.

use super::fleet::Fleet;
use super::trainer::{self, Reviewer, TrainerFlight, covered_share, is_same};
use super::{SimError, Simulation};
use crate::autopilot::Stage;
use crate::connection::{Address, Connection};
use crate::mission::{Mission, PoiMap};
use crate::node::run::{Control, Links, Report, run};
use crate::node::{Counters, Decision, FeedForward, Node, Settings, StepBegun, gate_limits};
use crate::signing::Session;
use crate::swarm_link::{SwarmAddress, SwarmSocket, system_of};
use crate::tlog::TlogWriter;
use covey_env::{EpisodeMetrics, World};
use firmware_core::action::Action;
use firmware_core::gate::Limits;
use firmware_core::geometry::State;
use serde_json::{Value, json};
use std::io;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The fleet's clock begins here, so that every run is the same: 2026-11-22, Unix time in ms.
const START_UNIX_MS: i64 = 1_795_305_600_000;
/// The fleet moves at this many times real time until everybody streams.
const BRING_UP_SPEED: f64 = 40.0;
/// Everybody is in the air by then, simulated ms.
const BRING_UP_MS: i64 = 5 * 60_000;
/// From the moment when all are in the air to step 0, simulated ms.
const LEAD_MS: i64 = 10_000;
/// A flight that stands still for so long has failed.
const STALLED: Duration = Duration::from_secs(20);

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

pub(super) fn fly(
    sim: &Simulation<'_>,
    index: u64,
    world: &World,
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
        let flown = Fleet::start(&sim.python, &fleet_config(sim, world, &mission, &ports), sim.verbose)
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
        account(sim, index, world, &mut flight);
        Ok(flight)
    })
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
        limits: Limits { stream_before_mode: sim.px4, ..limits },
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

fn fleet_config(sim: &Simulation<'_>, world: &World, mission: &Mission, ports: &[u16]) -> Value {
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
        "speed": sim.speed.unwrap_or(BRING_UP_SPEED),
        "seed": sim.seed,
        "signing_key_file": sim.key_file,
        "unix_ms": START_UNIX_MS,
    });
    for (name, value) in &sim.fleet {
        config[name] = value.clone();
    }
    config
}

/// Leads a flight from the ground to its last step.
struct Director<'s> {
    sim: &'s Simulation<'s>,
    world: &'s World,
    step_ms: i64,
    fleet: Fleet,
    reports: &'s Receiver<(usize, Report)>,
    stop: &'s AtomicBool,
    epoch_ms: &'s AtomicI64,
    stages: Vec<Stage>,
    words: Vec<String>,
    clock_ms: i64,
    flight: WorldFlight,
    /// Steps begun by each UAV.
    begun: Vec<u32>,
    first_step: Option<Instant>,
    last_step: Instant,
}

impl<'s> Director<'s> {
    fn new(
        sim: &'s Simulation<'s>,
        world: &'s World,
        mission: &Mission,
        fleet: Fleet,
        reports: &'s Receiver<(usize, Report)>,
        stop: &'s AtomicBool,
        epoch_ms: &'s AtomicI64,
    ) -> Self {
        let (uavs, steps) = (sim.scenario.uavs, sim.scenario.steps as usize);
        Self {
            sim,
            world,
            step_ms: i64::from(mission.scale.step_ms),
            fleet,
            reports,
            stop,
            epoch_ms,
            stages: vec![Stage::Silent; uavs],
            words: vec![String::new(); uavs],
            clock_ms: START_UNIX_MS,
            flight: WorldFlight {
                states: vec![vec![None; uavs]; steps + 1],
                decisions: vec![vec![None; uavs]; steps],
                ..WorldFlight::default()
            },
            begun: vec![0; uavs],
            first_step: None,
            last_step: Instant::now(),
        }
    }

    fn direct(mut self) -> Result<WorldFlight, SimError> {
        let began = Instant::now();
        while self.stages.iter().any(|&stage| stage != Stage::Flying) {
            self.turn()?;
            if self.clock_ms - START_UNIX_MS > BRING_UP_MS || self.stages.contains(&Stage::Failed) {
                return Err(SimError::NotAirborne { minutes: BRING_UP_MS / 60_000, who: self.missing() });
            }
        }
        // On a boundary of the fleet's own ticks, which divide a step.
        let epoch_ms =
            START_UNIX_MS + (self.clock_ms - START_UNIX_MS + LEAD_MS).div_euclid(self.step_ms) * self.step_ms;
        self.fleet.command(&json!({"epoch_unix_ms": epoch_ms}));
        self.epoch_ms.store(epoch_ms, Ordering::Relaxed);
        self.last_step = Instant::now();
        let steps = self.sim.scenario.steps;
        while self.begun.iter().any(|&begun| begun <= steps) {
            self.turn()?;
            if self.last_step.elapsed() > STALLED {
                let step = self.begun.iter().copied().min().unwrap_or(0);
                return Err(SimError::Stalled { seconds: STALLED.as_secs(), step, who: self.missing() });
            }
        }
        let first = self.first_step.unwrap_or(began);
        self.flight.wall_s = (self.last_step - first).as_secs_f64();
        self.flight.bring_up_s = (first - began).as_secs_f64();
        self.flight.simulated_s = f64::from(steps) * self.step_ms as f64 / 1000.0;
        for event in self.fleet.stop() {
            self.hear(&event);
        }
        Ok(self.flight)
    }

    /// Takes in what nodes and fleet tell.
    fn turn(&mut self) -> Result<(), SimError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(SimError::Stopped);
        }
        match self.reports.recv_timeout(Duration::from_millis(20)) {
            Ok((id, report)) => self.take(id, report)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(SimError::Stopped),
        }
        while let Ok((id, report)) = self.reports.try_recv() {
            self.take(id, report)?;
        }
        for event in self.fleet.events()? {
            self.hear(&event);
        }
        Ok(())
    }

    fn take(&mut self, id: usize, report: Report) -> Result<(), SimError> {
        match report {
            Report::Notice(notice) => {
                if self.sim.verbose || (notice.warning && self.first_step.is_some()) {
                    eprintln!("UAV {id}: {notice}");
                }
                self.words[id] = notice.text;
            }
            Report::Stage(stage) => self.stages[id] = stage,
            Report::Clock(common_ms) => self.clock_ms = self.clock_ms.max(common_ms),
            Report::Begun(begun) => self.begin(id, &begun)?,
            Report::Decision(decision) => {
                if let Some(row) = self.flight.decisions.get_mut(decision.step as usize) {
                    row[id] = Some(decision);
                }
            }
            Report::Ended(counters) => self.flight.counters.add(&counters),
            Report::Status(_) => {}
        }
        Ok(())
    }

    fn begin(&mut self, id: usize, begun: &StepBegun) -> Result<(), SimError> {
        if self.begun[id] == 0 && begun.step != 0 {
            return Err(SimError::MissedStart(id));
        }
        self.begun[id] = begun.step.saturating_add(1);
        self.last_step = Instant::now();
        self.first_step.get_or_insert(self.last_step);
        if let Some(row) = self.flight.states.get_mut(begun.step as usize) {
            row[id] = Some(begun.state);
        }
        Ok(())
    }

    fn hear(&mut self, event: &Value) {
        match event["event"].as_str() {
            Some("truth") => {
                let steps = self.sim.scenario.steps as usize;
                let step = event["step"].as_u64().unwrap_or(0) as usize;
                if (1..=steps).contains(&step)
                    && let Some(share) = true_share(self.world, &event["u"])
                {
                    self.flight.true_coverage.push(share);
                }
            }
            Some("timeout" | "failsafe" | "crash" | "lockstep_timeout" | "error") => {
                if self.sim.verbose {
                    eprintln!("fleet: {event}");
                }
                self.flight.trouble.push(event.clone());
            }
            _ => {}
        }
    }

    /// Who is behind, and what each said last.
    fn missing(&self) -> String {
        let behind = |&id: &usize| {
            self.stages[id] != Stage::Flying
                || (self.first_step.is_some() && Some(&self.begun[id]) == self.begun.iter().min())
        };
        let one = |id: usize| format!("UAV {id} ({}; {})", self.stages[id].name(), self.words[id]);
        (0..self.stages.len()).filter(behind).take(3).map(one).collect::<Vec<_>>().join(", ")
    }
}

/// Share of PoIs covered from positions in u.
fn true_share(world: &World, positions: &Value) -> Option<f64> {
    let places: Option<Vec<(f32, f32)>> = positions
        .as_array()?
        .iter()
        .map(|place| Some((place[0].as_f64()? as f32, place[1].as_f64()? as f32)))
        .collect();
    share_at(world, &places?)
}

/// Share of PoIs covered from these places; outside the map counts as its edge.
fn share_at(world: &World, places: &[(f32, f32)]) -> Option<f64> {
    let side = world.scenario().side_u;
    let inside: Vec<_> = places.iter().map(|&(x, y)| (x.clamp(0.0, side), y.clamp(0.0, side))).collect();
    let pois: Vec<_> = world.poi_x().iter().copied().zip(world.poi_y().iter().copied()).collect();
    let mut scene = world.clone();
    scene.set_layout(&inside, &pois).ok()?;
    Some(covered_share(&scene))
}

/// Compares with the trainer.
fn account(sim: &Simulation<'_>, index: u64, world: &World, flight: &mut WorldFlight) {
    let policy_seed = super::policy_seed(sim.seed, index);
    let trained = trainer::fly(world.clone(), sim.actor, policy_seed, sim.mode);
    for row in flight.states.iter().skip(1) {
        let known: Vec<(f32, f32)> = row.iter().flatten().map(|state| state.position.to_u()).collect();
        // With a UAV unknown there is no state to score; the fleet's truth has them all.
        let share = if known.len() == row.len() { share_at(world, &known) } else { None };
        flight.coverage.push(share.unwrap_or_else(|| flight.coverage.last().copied().unwrap_or(0.0)));
    }
    if sim.ideal {
        compare_flights(&trained, flight);
    } else {
        review(Reviewer::new(world.clone(), sim.actor, policy_seed, sim.mode), flight);
    }
    flight.trainer = trained.metrics;
    flight.trainer_coverage = trained.coverage;
}

fn compare_flights(trained: &TrainerFlight, flight: &mut WorldFlight) {
    for (step, row) in flight.decisions.iter().enumerate() {
        for (id, decision) in row.iter().enumerate() {
            let Some(decision) = decision else { continue };
            flight.compared += 1;
            let same = is_same(decision, trained.observations[step][id], trained.actions[step][id]);
            flight.equal += u64::from(same);
            if !same && flight.first_difference.is_none() {
                let (observation, action) = (trained.observations[step][id], trained.actions[step][id]);
                flight.first_difference = Some(difference(id, decision, observation, action));
            }
        }
    }
}

/// A decision that is not the trainer's, in words.
fn difference(id: usize, decision: &Decision, observation: u64, action: Action) -> String {
    let seen = if decision.observation == observation { "the same" } else { "another" };
    let ((x, y), (vx, vy)) = (decision.state.position.to_u(), decision.state.velocity.to_u());
    format!(
        "step {}, UAV {id} at ({x}, {y}) u with ({vx}, {vy}) u/step: action {} on {seen} observation, the trainer's is {}; \
         neighbours {:?}, {} of them with a feature",
        decision.step,
        decision.action,
        action.index(),
        decision.neighbours(),
        decision.features,
    )
}

fn review(mut reviewer: Reviewer<'_>, flight: &mut WorldFlight) {
    for (step, row) in flight.decisions.iter().enumerate() {
        let states: Option<Vec<State>> = flight.states[step].iter().copied().collect();
        let Some(expected) = states.and_then(|states| reviewer.review(step as u32, &states)) else { continue };
        for (id, (decision, (observation, action))) in (0u16..).zip(row.iter().zip(expected)) {
            let Some(decision) = decision else { continue };
            flight.compared += 1;
            let same = is_same(decision, observation, action);
            flight.equal += u64::from(same);
            if !same && flight.first_difference.is_none() {
                flight.first_difference = Some(difference(usize::from(id), decision, observation, action));
            }
        }
    }
}
