//! `fly`: one UAV.

use super::actor_file::flight_ready;
use super::args::{ActorArgs, SigningArgs, TimingArgs};
use super::console::{Console, stop_flag};
use super::mission;
use super::recording::create;
use crate::connection::{Address, Connection};
use crate::node::run::{Links, NodeEvent, RunControl, run};
use crate::node::{Node, Settings, gate_limits};
use crate::outlet::{say, stdout};
use crate::status_view::{StatusView, ViewMode};
use crate::swarm_link::{SwarmAddress, SwarmSocket};
use firmware_core::gate::Limits;
use miette::{IntoDiagnostic as _, Result, WrapErr as _};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::channel;

/// Arguments of `fly`.
#[derive(clap::Args)]
pub(crate) struct Fly {
    /// The UAV's id, 0 to 254: no two of a swarm have the same.
    #[arg(long)]
    id: u16,
    /// The autopilot's link: udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or
    /// serial:/dev/ttyX:BAUD.
    #[arg(long, default_value = "udpin:0.0.0.0:14550")]
    autopilot: Address,
    /// The swarm's link: multicast:GROUP:PORT, broadcast:ADDRESS:PORT or
    /// peers:LISTEN:PORT,PEER:PORT,...; the UAV flies alone when left out.
    #[arg(long)]
    swarm: Option<SwarmAddress>,
    /// The mission file, TOML or GeoJSON.
    #[arg(long)]
    mission: PathBuf,
    /// Arm, take off and fly. Otherwise the UAV flies once its pilot has brought it up and set
    /// GUIDED (PX4: OFFBOARD).
    #[arg(long)]
    takeoff: bool,
    /// Refuse to start while a parameter of the autopilot costs what docs/safety.md says, or is not told;
    /// otherwise warn.
    #[arg(long)]
    strict: bool,
    /// Land where it is when this program ends. Otherwise the autopilot holds the place.
    #[arg(long)]
    land_on_exit: bool,
    /// So many UAVs start together, this one included: it holds on its layer until it hears all of them in the
    /// air.
    #[arg(long, value_name = "UAVS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=255))]
    wait_for: u16,
    /// The autopilot is simulated, and its clock may run at any speed.
    #[arg(long)]
    simulated: bool,
    /// MAVLink system id of this node towards the autopilot; id + 1 when left out. With 255
    /// ArduPilot's ground-station failsafe watches this node.
    #[arg(long)]
    system: Option<u8>,
    /// MAVLink system id of the vehicle to fly; id + 1 when left out. Other vehicles on the link are not
    /// listened to.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..))]
    vehicle_system: Option<u8>,
    /// Record all MAVLink traffic.
    #[arg(long, value_name = "FILE")]
    tlog: Option<PathBuf>,
    /// Print steps and decisions as JSON lines.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    actor: ActorArgs,
    #[command(flatten)]
    timing: TimingArgs,
    #[command(flatten)]
    signing: SigningArgs,
}

impl Fly {
    /// Flies until it is stopped.
    ///
    /// # Errors
    /// A file cannot be used or a link not be opened; the actor does not pass its self-test.
    pub fn run(self) -> Result<()> {
        let stop = stop_flag()?;
        let (bytes, name) = self.actor.read().into_diagnostic()?;
        let actor = flight_ready(&bytes, &name).into_diagnostic()?;
        let mission = Arc::new(mission::read(&self.mission)?);
        let (autopilot_signing, swarm_signing) = self.signing.links()?;
        let autopilot = Connection::open(&self.autopilot).into_diagnostic().wrap_err("no link to the autopilot")?;
        let swarm = self.swarm.as_ref().map(SwarmSocket::open).transpose().into_diagnostic()?;
        let tlog = self.tlog.as_ref().map(|path| create(path)).transpose()?;
        say(&format!("autopilot: {}", autopilot.describe()));
        match &swarm {
            Some(socket) => {
                say(&socket.describe());
                self.signing.keyless_warning().into_iter().for_each(say);
            }
            None => say("no --swarm: flying alone"),
        }
        let base = if self.simulated { Limits::simulation() } else { Limits::default() };
        let settings = Settings {
            timing: self.timing.timing(mission.scale.step_ms)?,
            limits: gate_limits(base, &mission),
            take_off: self.takeoff,
            wait_for: self.wait_for,
            strict: self.strict,
            rate_hz: f64::from(self.timing.rate_hz()),
            source: autopilot.source(),
            autopilot_signing,
            swarm_signing,
            record: tlog.is_some(),
            advice: autopilot.advice(),
            ..Settings::new(self.id, actor, Arc::clone(&mission))
        };
        let settings = Settings {
            system: self.system.unwrap_or(settings.system),
            vehicle_system: self.vehicle_system.unwrap_or(settings.vehicle_system),
            ..settings
        };
        let mut node = Node::new(settings, self.signing.session(None)?).into_diagnostic()?;
        mission.layers.check(self.id).into_diagnostic()?;
        let mut control = RunControl::new(stop, self.land_on_exit);
        let console = Console::default();
        control.commands = Some(console.listener());
        console.listen();
        let (events, received) = channel();
        let json = self.json;
        let mut view = StatusView::new(ViewMode::detect(false), String::new(), self.id, 1, &mission.pois);
        let printer = std::thread::spawn(move || {
            for (_, event) in received {
                view.update(0, &event);
                print(&event, json, &mut view);
            }
            view.finish();
        });
        let links = Links { autopilot, swarm, tlog };
        let flown = run(&mut node, links, &control, 0, &events).into_diagnostic();
        drop(events);
        let _ = printer.join();
        say(&format!("stopped: {}", parting(node.is_airborne(), self.land_on_exit)));
        flown
    }
}

/// What happens to the vehicle, or to several, when the program ends.
pub(super) const fn parting(airborne: bool, land: bool) -> &'static str {
    match (airborne, land) {
        (false, _) => "nothing was in the air",
        (true, false) => "no more setpoints; the autopilot holds the place by itself",
        (true, true) => "no more setpoints; the autopilot was asked to land",
    }
}

/// A line on standard output. Where that is closed, its disk full or nobody reads it, the flight and the warnings
/// on standard error go on.
fn write_line(line: &serde_json::Value) {
    stdout().write(format!("{line}\n"));
}

/// Prints an event: as a JSON line on standard output, or in words for the operator.
fn print(event: &NodeEvent, json: bool, view: &mut StatusView) {
    match event {
        NodeEvent::Notice(notice) => {
            view.print(&format!("{}{notice}", if notice.warning { "warning: " } else { "" }));
        }
        NodeEvent::StepStarted(step) if json => {
            let ((x, y), (vx, vy)) = (step.state.position.to_u(), step.state.velocity.to_u());
            write_line(
                &serde_json::json!({"step": step.step, "common_ms": step.common_ms, "u": [x, y], "v": [vx, vy]}),
            );
        }
        NodeEvent::Decision(d) => {
            if json {
                let line = serde_json::json!({
                    "step": d.step, "decision": d.action, "boot_ms": d.boot_ms, "phase_ms": d.phase_ms, "late": d.late,
                    "observation": format!("{:016x}", d.observation), "neighbours": d.neighbours(), "features": d.features,
                });
                write_line(&line);
            } else if d.late {
                view.print(&format!("warning: step {}: decided {} ms after its beginning", d.step, d.phase_ms));
            }
        }
        NodeEvent::StepStarted(_)
        | NodeEvent::Stage(_)
        | NodeEvent::Clock(_)
        | NodeEvent::Status(_)
        | NodeEvent::Ended(_) => {}
    }
}
