//! `swarm` over real links.

use super::shared::SharedArgs;
use crate::commands::console::Console;
use crate::commands::fly::parting;
use crate::commands::mission;
use crate::commands::output::print;
use crate::commands::recording::create;
use crate::connection::{Address, Connection};
use crate::mission::PoiMap;
use crate::node::run::{Links, NodeEvent, RunControl, run};
use crate::node::{Counters, Node, Settings, gate_limits};
use crate::outlet::say;
use crate::status_view::{StatusView, ViewMode};
use crate::swarm_link::{SwarmAddress, SwarmSocket, system_of};
use firmware_core::actor::Actor;
use firmware_core::gate::Limits;
use miette::{IntoDiagnostic as _, Result, miette};
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;

/// Arguments without `--sim`.
#[derive(clap::Args)]
pub(super) struct RealArgs {
    /// Id of the first UAV; the others follow.
    #[arg(long, default_value_t = 0, conflicts_with = "sim")]
    first_id: u16,
    /// Link of the first autopilot.
    #[arg(long, default_value = "udpin:0.0.0.0:14550")]
    autopilot: Address,
    /// MAVLink system id of the first UAV's vehicle, the others follow; each UAV's id + 1 when left out.
    #[arg(long, conflicts_with = "sim", value_parser = clap::value_parser!(u8).range(1..))]
    vehicle_system: Option<u8>,
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
    /// Refuse to start while a parameter of an autopilot costs what docs/safety.md says, or is not told;
    /// otherwise warn.
    #[arg(long, conflicts_with = "sim")]
    strict: bool,
    /// Land where they are when this program ends.
    #[arg(long)]
    land_on_exit: bool,
    /// MAVLink system id of all nodes towards their autopilots; each its id + 1 when left out. With 255
    /// ArduPilot's ground-station failsafe watches the nodes.
    #[arg(long, conflicts_with = "sim")]
    system: Option<u8>,
    /// The autopilots are simulated, and their clocks may run at any speed.
    #[arg(long)]
    simulated: bool,
}

impl RealArgs {
    /// Flies until `stop` is set.
    ///
    /// # Errors
    /// A file cannot be used or a link not be opened.
    pub fn fly(&self, shared: &SharedArgs, actor: Actor<'_>, stop: &Arc<AtomicBool>) -> Result<()> {
        let Some(path) = &self.mission else { return Err(miette!("--mission is missing")) };
        let mission = Arc::new(mission::read(path)?);
        let pois = Arc::new(PoiMap::new(&mission.pois));
        let (autopilot_signing, swarm_signing) = shared.signing.links()?;
        // Without --swarm the link does not leave this computer.
        if let Some(text) = shared.signing.keyless_warning().filter(|_| self.swarm.is_some()) {
            say(text);
        }
        let base = if self.simulated { Limits::simulation() } else { Limits::default() };
        let mut nodes = Vec::new();
        for (i, links) in self.links(shared)?.into_iter().enumerate() {
            let id = self.first_id + i as u16;
            mission.layers.check(id).into_diagnostic()?;
            let settings = Settings {
                vehicle_system: self.vehicle_of(i, id)?,
                pois: Arc::clone(&pois),
                timing: shared.timing.timing(mission.scale.step_ms)?,
                limits: gate_limits(base, &mission),
                take_off: self.takeoff,
                wait_for: shared.count,
                strict: self.strict,
                rate_hz: f64::from(shared.timing.rate_hz()),
                source: links.autopilot.source(),
                autopilot_signing: autopilot_signing.clone(),
                swarm_signing: swarm_signing.clone(),
                record: links.tlog.is_some(),
                advice: links.autopilot.advice(),
                ..Settings::new(id, actor, Arc::clone(&mission))
            };
            let settings = Settings { system: self.system.unwrap_or(settings.system), ..settings };
            say(&format!("UAV {id}: {}", links.autopilot.describe()));
            nodes.push((Node::new(settings, shared.signing.session(Some(id))?).into_diagnostic()?, links));
        }
        let console = Console::default();
        let (events, received) = channel();
        let mut counters = Counters::default();
        let airborne = AtomicBool::new(false);
        let mode = ViewMode::detect(shared.verbose);
        let mut view = StatusView::new(mode, String::new(), self.first_id, usize::from(shared.count), &mission.pois);
        let flown: std::io::Result<()> = thread::scope(|scope| {
            let threads: Vec<_> = nodes
                .drain(..)
                .enumerate()
                .map(|(i, (mut node, links))| {
                    let mut control = RunControl::new(Arc::clone(stop), self.land_on_exit);
                    control.commands = Some(console.listener());
                    let events = events.clone();
                    let airborne = &airborne;
                    scope.spawn(move || {
                        let flown = run(&mut node, links, &control, i, &events);
                        airborne.fetch_or(node.is_airborne(), Ordering::Relaxed);
                        flown
                    })
                })
                .collect();
            drop(events);
            console.listen();
            for (i, event) in received {
                let id = usize::from(self.first_id) + i;
                view.update(i, &event);
                match event {
                    NodeEvent::Notice(notice) if notice.warning || shared.verbose => {
                        view.print(&format!("UAV {id}: {notice}"));
                    }
                    NodeEvent::Ended(counts) => counters.add(&counts),
                    _ => {}
                }
            }
            threads
                .into_iter()
                .try_for_each(|thread| thread.join().unwrap_or_else(|_| Err(std::io::Error::other("a node panicked"))))
        });
        view.finish();
        say(&format!("stopped: {}", parting(airborne.load(Ordering::Relaxed), self.land_on_exit)));
        if shared.json {
            print(&format!("{}\n", counters.to_json(shared.count)))?;
        }
        flown.into_diagnostic()
    }

    /// System id of the vehicle of the `i`-th UAV, which has this id.
    fn vehicle_of(&self, i: usize, id: u16) -> Result<u8> {
        let first = self.vehicle_system.map_or(usize::from(self.first_id) + 1, usize::from);
        u8::try_from(first + i)
            .map_err(|_| miette!("--vehicle-system {first}: none is left for UAV {id}, they end at 255"))
    }

    /// Opens the links of all nodes.
    fn links(&self, shared: &SharedArgs) -> Result<Vec<Links>> {
        let mut links = Vec::new();
        for i in 0..shared.count {
            let id = self.first_id.checked_add(i).filter(|&id| system_of(id).is_some());
            let id =
                id.ok_or_else(|| miette!("--first-id {} --count {}: ids go up to 254", self.first_id, shared.count))?;
            let address = nth_address(&self.autopilot, i, self.port_step).ok_or_else(|| {
                miette!("--autopilot {} with --port-step {}: no link for UAV {id}", self.autopilot, self.port_step)
            })?;
            let autopilot = Connection::open(&address).into_diagnostic()?;
            let own = SwarmAddress::Peers { listen: (Ipv4Addr::LOCALHOST, 0).into(), peers: Vec::new() };
            let swarm = SwarmSocket::open(self.swarm.as_ref().unwrap_or(&own)).into_diagnostic()?;
            let file = |folder: &PathBuf| create(&folder.join(format!("uav-{id}.tlog")));
            let tlog = shared.tlog.as_ref().map(file).transpose()?;
            links.push(Links { autopilot, swarm: Some(swarm), tlog });
        }
        if self.swarm.is_none() {
            let peers: Vec<_> = links.iter().filter_map(|l| l.swarm.as_ref()).map(SwarmSocket::listens_on).collect();
            for swarm in links.iter_mut().filter_map(|l| l.swarm.as_mut()) {
                let own = swarm.listens_on();
                swarm.set_peers(&peers.iter().copied().filter(|&peer| peer != own).collect::<Vec<_>>());
            }
        }
        Ok(links)
    }
}

/// The link of the `i`-th autopilot: its port is `i` times `step` higher. A serial line has no port and
/// serves only the first.
fn nth_address(address: &Address, i: u16, step: u16) -> Option<Address> {
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
