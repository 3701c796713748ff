//! `swarm`: several UAVs from one computer, real or simulated ones.

use super::actor_file::flight_ready;
use super::common::{ActorArgs, Console, SigningArgs, TimingArgs, stop_flag};
use super::fly::{parting, recording};
use super::mission;
use super::sim::{Page, Simulation, WorldFlight, find_python};
use super::view::{View, ViewMode};
use crate::connection::{Address, Connection};
use crate::mission::PoiMap;
use crate::node::run::{Control, Links, Report, run};
use crate::node::{Counters, FeedForward, Node, Settings, gate_limits};
use crate::swarm_link::{SwarmAddress, SwarmSocket, system_of};
use crate::tlog::flight_folder;
use covey_env::Scenario;
use firmware_core::actor::{Actor, Mode};
use firmware_core::gate::Limits;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;

/// Arguments of `swarm`.
#[derive(clap::Args)]
pub struct Swarm {
    /// Number of UAVs.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=255))]
    count: u16,
    /// Id of the first; the others follow.
    #[arg(long, default_value_t = 0, conflicts_with = "sim")]
    first_id: u16,
    /// Fly against simulated autopilots, started here, and compare with the trainer.
    #[arg(long)]
    sim: bool,
    #[command(flatten)]
    real: RealArgs,
    #[command(flatten)]
    simulated: SimArgs,
    /// End with one JSON object.
    #[arg(long)]
    json: bool,
    /// Folder for recordings of all MAVLink traffic, one file a UAV; with --sim each world's
    /// mission too.
    #[arg(long, value_name = "FOLDER", alias = "tlogs")]
    tlog: Option<PathBuf>,
    /// Tell everything.
    #[arg(long, short)]
    verbose: bool,
    #[command(flatten)]
    actor: ActorArgs,
    #[command(flatten)]
    timing: TimingArgs,
    #[command(flatten)]
    signing: SigningArgs,
}

/// Only without `--sim`.
#[derive(clap::Args)]
struct RealArgs {
    /// Link of the first autopilot.
    #[arg(long, default_value = "udpin:0.0.0.0:14550")]
    autopilot: Address,
    /// How much higher the port of each next autopilot is: 10 for ArduPilot's simulator, 1 for
    /// PX4's.
    #[arg(long, default_value_t = 10)]
    port_step: u16,
    /// The swarm's link; these nodes alone, on this computer, when left out.
    #[arg(long)]
    swarm: Option<SwarmAddress>,
    /// The mission file, TOML or GeoJSON.
    #[arg(long, required_unless_present = "sim")]
    mission: Option<PathBuf>,
    /// Arm, take off and fly.
    #[arg(long)]
    takeoff: bool,
    /// Land where they are when this program ends.
    #[arg(long)]
    land_on_exit: bool,
    /// The autopilots are simulated, and their clocks may run at any speed.
    #[arg(long)]
    simulated: bool,
}

/// Only with `--sim`.
#[derive(clap::Args)]
struct SimArgs {
    /// The scenario's own dynamics: then every action is the trainer's.
    #[arg(long, requires = "sim")]
    ideal: bool,
    /// Simulated autopilots are PX4 instead of ArduPilot.
    #[arg(long, requires = "sim")]
    px4: bool,
    /// Worlds to fly, one after the other.
    #[arg(long, default_value_t = 1)]
    worlds: u64,
    /// Index of the first of them.
    #[arg(long, default_value_t = 0)]
    first_world: u64,
    /// Seed of the worlds.
    #[arg(long, default_value_t = 777)]
    seed: u64,
    /// Number of PoIs.
    #[arg(long, default_value_t = 120)]
    pois: usize,
    /// Steps in a world.
    #[arg(long, default_value_t = 100)]
    steps: u32,
    /// Run at so many times real time instead of as fast as nodes and fleet can together.
    #[arg(long, requires = "sim")]
    speed: Option<f64>,
    /// Take the most likely action instead of drawing one.
    #[arg(long, requires = "sim")]
    argmax: bool,
    /// Python with the packages of the simulated autopilots.
    #[arg(long)]
    python: Option<PathBuf>,
    /// Page that plays the flights beside the trainer's of the same worlds, an HTML file.
    #[arg(long, value_name = "FILE", requires = "sim")]
    report: Option<PathBuf>,
    /// JSON object set over the fleet's configuration, such as '{"wind": [3, 0]}'.
    #[arg(long, requires = "sim", value_parser = object)]
    fleet: Option<serde_json::Map<String, serde_json::Value>>,
}

fn object(text: &str) -> Result<serde_json::Map<String, serde_json::Value>, String> {
    serde_json::from_str(text).map_err(|e| format!("no JSON object: {e}"))
}

impl Swarm {
    /// Flies until it is stopped or, simulated, until the last step.
    ///
    /// # Errors
    /// A file cannot be used or a link not be opened; the actor does not pass its self-test;
    /// the simulation fails.
    pub fn run(mut self) -> Result<()> {
        let stop = stop_flag()?;
        let (bytes, name) = self.actor.read().into_diagnostic()?;
        let actor = flight_ready(&bytes, &name).into_diagnostic()?;
        if let Some(folder) = &mut self.tlog {
            let fresh = flight_folder(folder).into_diagnostic().wrap_err("the recordings have no folder")?;
            if fresh != *folder {
                eprintln!(
                    "{} has recordings, which are kept: those of this flight go to {}",
                    folder.display(),
                    fresh.display()
                );
            }
            *folder = fresh;
        }
        if self.sim { self.simulate(actor, &stop) } else { self.fly(actor, &stop) }
    }

    fn simulate(self, actor: Actor<'_>, stop: &Arc<AtomicBool>) -> Result<()> {
        let args = self.simulated;
        let scenario =
            Scenario { uavs: usize::from(self.count), pois: args.pois, steps: args.steps, ..Scenario::default() };
        scenario.validate().into_diagnostic()?;
        if args.speed.is_some_and(|speed| !(0.1..=1000.0).contains(&speed)) {
            return Err(miette!("--speed: use 0.1 to 1000"));
        }
        let timing = self.timing.timing(firmware_core::neighbour_table::DEFAULT_STEP_MS)?;
        let simulation = Simulation {
            seed: args.seed,
            mode: if args.argmax { Mode::Argmax } else { Mode::Sample },
            ideal: args.ideal,
            px4: args.px4,
            speed: args.speed,
            timing,
            rate_hz: self.timing.rate_hz(),
            python: find_python(args.python.as_deref()),
            signing: self.signing.links()?,
            key_file: self.signing.key_file().map(Into::into),
            fleet: args.fleet.unwrap_or_default(),
            tlogs: self.tlog,
            view: ViewMode::detect(self.verbose),
            verbose: self.verbose,
            ..Simulation::new(actor, scenario)
        };
        let json = self.json;
        let mut page = args.report.map(|path| (path, Page::default(), Ok(())));
        let summary =
            simulation.run(args.first_world..args.first_world.saturating_add(args.worlds), stop, |index, flight| {
                if let Some((_, page, made)) = page.as_mut().filter(|(.., made)| made.is_ok()) {
                    *made = page.add(&simulation, index, flight);
                }
                eprintln!("{}", line(index, flight));
                if let (Some(difference), true) = (&flight.first_difference, self.verbose || args.ideal) {
                    eprintln!("  the first other decision: {difference}");
                }
            });
        let summary = summary.into_diagnostic()?;
        if let Some((path, page, made)) = page {
            made.and_then(|()| page.write(&path, &simulation, &summary)).into_diagnostic()?;
            eprintln!("{} plays the flight{}", path.display(), if summary.worlds == 1 { "" } else { "s" });
        }
        if json {
            println!("{}", serde_json::to_string_pretty(&summary).into_diagnostic()?);
        } else {
            println!("{summary}");
        }
        Ok(())
    }

    fn fly(self, actor: Actor<'_>, stop: &Arc<AtomicBool>) -> Result<()> {
        let Some(path) = &self.real.mission else { return Err(miette!("--mission is missing")) };
        let mission = Arc::new(mission::read(path)?);
        let pois = Arc::new(PoiMap::new(&mission.pois));
        let (autopilot_signing, swarm_signing) = self.signing.links()?;
        let base = if self.real.simulated { Limits::simulation() } else { Limits::default() };
        let mut crew = Vec::new();
        for (i, links) in self.links()?.into_iter().enumerate() {
            let id = self.first_id + i as u16;
            let settings = Settings {
                id,
                system: system_of(id).unwrap_or(u8::MAX),
                actor,
                mission: Arc::clone(&mission),
                pois: Arc::clone(&pois),
                timing: self.timing.timing(mission.scale.step_ms)?,
                limits: gate_limits(base, &mission),
                feed_forward: FeedForward::Ramp,
                take_off: self.real.takeoff,
                rate_hz: f64::from(self.timing.rate_hz()),
                source: links.autopilot.source(),
                autopilot_signing: autopilot_signing.clone(),
                swarm_signing: swarm_signing.clone(),
                record: links.tlog.is_some(),
                advice: links.autopilot.advice(),
            };
            eprintln!("UAV {id}: {}", links.autopilot.describe());
            crew.push((Node::new(settings, self.signing.session(Some(id))?).into_diagnostic()?, links));
        }
        let console = Console::default();
        let (reports, received) = channel();
        let mut counters = Counters::default();
        let airborne = AtomicBool::new(false);
        let mode = ViewMode::detect(self.verbose);
        let mut view = View::new(mode, String::new(), self.first_id, usize::from(self.count), &mission.pois);
        let flown: std::io::Result<()> = thread::scope(|scope| {
            let threads: Vec<_> = crew
                .drain(..)
                .enumerate()
                .map(|(i, (mut node, links))| {
                    let mut control = Control::new(Arc::clone(stop), self.real.land_on_exit);
                    control.orders = Some(console.listener());
                    let reports = reports.clone();
                    let airborne = &airborne;
                    scope.spawn(move || {
                        let flown = run(&mut node, links, &control, i, &reports);
                        airborne.fetch_or(node.is_airborne(), Ordering::Relaxed);
                        flown
                    })
                })
                .collect();
            drop(reports);
            console.listen();
            for (i, report) in received {
                let id = usize::from(self.first_id) + i;
                view.hear(i, &report);
                match report {
                    Report::Notice(notice) if notice.warning || self.verbose => {
                        view.say(&format!("UAV {id}: {notice}"));
                    }
                    Report::Ended(counts) => counters.add(&counts),
                    _ => {}
                }
            }
            threads
                .into_iter()
                .try_for_each(|thread| thread.join().unwrap_or_else(|_| Err(std::io::Error::other("a node panicked"))))
        });
        view.finish();
        eprintln!("stopped: {}", parting(airborne.load(Ordering::Relaxed), self.real.land_on_exit));
        if self.json {
            println!("{}", counters.to_json(self.count));
        }
        flown.into_diagnostic()
    }

    /// Links of all nodes.
    fn links(&self) -> Result<Vec<Links>> {
        let mut links = Vec::new();
        for i in 0..self.count {
            let id = self.first_id.checked_add(i).filter(|&id| system_of(id).is_some());
            let id =
                id.ok_or_else(|| miette!("--first-id {} --count {}: ids go up to 254", self.first_id, self.count))?;
            let address = moved(&self.real.autopilot, i, self.real.port_step).ok_or_else(|| {
                miette!(
                    "--autopilot {} with --port-step {}: no link for UAV {id}",
                    self.real.autopilot,
                    self.real.port_step
                )
            })?;
            let autopilot = Connection::open(&address).into_diagnostic()?;
            let own = SwarmAddress::Peers { listen: (Ipv4Addr::LOCALHOST, 0).into(), peers: Vec::new() };
            let swarm = SwarmSocket::open(self.real.swarm.as_ref().unwrap_or(&own)).into_diagnostic()?;
            let file = |folder: &PathBuf| recording(&folder.join(format!("uav-{id}.tlog")));
            let tlog = self.tlog.as_ref().map(file).transpose()?;
            links.push(Links { autopilot, swarm: Some(swarm), tlog });
        }
        if self.real.swarm.is_none() {
            let peers: Vec<_> = links.iter().filter_map(|l| l.swarm.as_ref()).map(SwarmSocket::listens_on).collect();
            for swarm in links.iter_mut().filter_map(|l| l.swarm.as_mut()) {
                let own = swarm.listens_on();
                swarm.set_peers(&peers.iter().copied().filter(|&peer| peer != own).collect::<Vec<_>>());
            }
        }
        Ok(links)
    }
}

/// The link of the `i`-th autopilot: its port is `i` steps higher. A link without a port serves one.
fn moved(address: &Address, i: u16, step: u16) -> Option<Address> {
    let mut address = address.clone();
    match &mut address {
        Address::UdpIn { port, .. }
        | Address::UdpOut { port, .. }
        | Address::Tcp { port, .. }
        | Address::TcpIn { port, .. } => {
            *port = port.checked_add(i.checked_mul(step)?)?;
            Some(address)
        }
        Address::Serial { .. } => (i == 0).then_some(address),
    }
}

/// The account of one world.
fn line(index: u64, flight: &WorldFlight) -> String {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    format!(
        "world {index}: coverage {:.4} (trainer {:.4}), {:.1}x real time, {} of {} decisions as the trainer's, {} late",
        mean(&flight.coverage),
        mean(&flight.trainer_coverage),
        flight.simulated_s / flight.wall_s.max(1e-9),
        flight.equal,
        flight.compared,
        flight.counters.late_decisions,
    )
}
