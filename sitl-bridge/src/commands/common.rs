//! Options that flights have in common.

use super::actor_file::ActorFileError;
use crate::node::{Order, Timing};
use crate::signing::{Key, LinkSigning, Session, StateFile, Timestamp, Unsigned};
use covey_env::open_actor;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::{io, thread};

/// Which actor flies.
#[derive(Clone, Debug, clap::Args)]
pub struct ActorArgs {
    /// The actor file; or gcn, gat or none: those that come with Covey [default: gcn].
    #[arg(long)]
    actor: Option<PathBuf>,
}

impl ActorArgs {
    /// The file's bytes and its name.
    pub(super) fn read(&self) -> Result<(Vec<u8>, PathBuf), ActorFileError> {
        let path = || self.actor.clone().unwrap_or_default();
        let read = open_actor(self.actor.as_deref());
        read.map(|(bytes, name)| (bytes, name.into())).map_err(|source| ActorFileError::Read { path: path(), source })
    }
}

/// When things happen in a step.
#[derive(Clone, Debug, clap::Args)]
pub struct TimingArgs {
    /// Positions asked of the autopilot, Hz; setpoints go out as often.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(2..=50))]
    rate_hz: u16,
    /// From a step's beginning until neighbours are viewed and the feature is told, ms.
    #[arg(long, default_value_t = 400)]
    encode_ms: u16,
    /// From a step's beginning until the decision, ms.
    #[arg(long, default_value_t = 800)]
    decide_ms: u16,
    /// Beacons a second; only the step's own when left out.
    #[arg(long)]
    beacon_hz: Option<f64>,
}

impl TimingArgs {
    pub(super) const fn rate_hz(&self) -> u16 {
        self.rate_hz
    }

    /// Whether nothing was said.
    pub(super) fn is_default(&self) -> bool {
        (self.rate_hz, self.encode_ms, self.decide_ms, self.beacon_hz) == (5, 400, 800, None)
    }

    /// Checked against the length of a step.
    pub(super) fn timing(&self, step_ms: u16) -> Result<Timing> {
        if !(self.encode_ms < self.decide_ms && self.decide_ms < step_ms) {
            return Err(miette!(
                "--encode-ms {} and --decide-ms {} must follow each other within a step of {step_ms} ms",
                self.encode_ms,
                self.decide_ms
            ));
        }
        let beacon_ms = match self.beacon_hz {
            None => None,
            Some(hz) if (0.1..=50.0).contains(&hz) => Some((1000.0 / hz).round() as u16),
            Some(hz) => return Err(miette!("--beacon-hz {hz}: use 0.1 to 50")),
        };
        let telemetry_ms = 1000 / self.rate_hz;
        Ok(Timing { encode_ms: self.encode_ms, decide_ms: self.decide_ms, beacon_ms, telemetry_ms })
    }
}

/// Keys of MAVLink 2's signatures.
#[derive(Clone, Debug, clap::Args)]
pub struct SigningArgs {
    /// File with the key of both links; only its owner may read it.
    #[arg(long, value_name = "FILE")]
    signing_key_file: Option<PathBuf>,
    /// Environment variable with the key of both links.
    #[arg(long, value_name = "NAME", conflicts_with = "signing_key_file")]
    signing_key_env: Option<String>,
    /// Sign the swarm's link only: the autopilot has no key.
    #[arg(long)]
    autopilot_unsigned: bool,
    /// File that keeps the signatures' time over a restart.
    #[arg(long, value_name = "FILE")]
    signing_state: Option<PathBuf>,
}

impl SigningArgs {
    /// Signing of the autopilot's and of the swarm's link.
    pub(super) fn links(&self) -> Result<(LinkSigning, LinkSigning)> {
        let key = match (&self.signing_key_file, &self.signing_key_env) {
            (Some(path), _) => Some(Key::from_file(path).into_diagnostic()?),
            (None, Some(name)) => Some(Key::from_environment(name).into_diagnostic()?),
            (None, None) => None,
        };
        let link =
            |key: Option<Key>, id| key.map_or_else(LinkSigning::off, |key| LinkSigning::new(key, id, Unsigned::Refuse));
        let autopilot = key.clone().filter(|_| !self.autopilot_unsigned);
        Ok((link(autopilot, 0), link(key, 1)))
    }

    pub(super) fn key_file(&self) -> Option<&Path> {
        self.signing_key_file.as_deref()
    }

    /// The session of a node; nodes of one process have a state file each.
    pub(super) fn session(&self, id: Option<u16>) -> Result<Session> {
        let Some(path) = &self.signing_state else { return Ok(Session::new()) };
        let mut path = path.clone();
        if let Some(id) = id {
            path.as_mut_os_string().push(format!(".{id}"));
        }
        let state = StateFile::open(&path).into_diagnostic()?;
        Session::with_state(state, Timestamp::now()).into_diagnostic().wrap_err("signatures have no time")
    }
}

/// What the operator types in flight, for any number of nodes.
#[derive(Debug, Default)]
pub struct Console(RefCell<Vec<Sender<Order>>>);

impl Console {
    /// One node's end.
    pub(super) fn listener(&self) -> Receiver<Order> {
        let (send, receive) = channel();
        self.0.borrow_mut().push(send);
        receive
    }

    /// Reads orders from the standard input from now on, until it ends. What is no order is
    /// answered with those there are.
    pub(super) fn listen(&self) {
        let nodes = self.0.take();
        thread::spawn(move || {
            for line in io::stdin().lines().map_while(Result::ok) {
                let order = match line.trim().to_ascii_lowercase().as_str() {
                    "" => continue,
                    "start" => Order::Start,
                    "release" => Order::Release,
                    "return" => Order::Return,
                    "land" => Order::Land,
                    other => {
                        eprintln!("`{other}`? start, release, return and land are understood; Ctrl-C ends");
                        continue;
                    }
                };
                // A node that has ended takes no more.
                for node in &nodes {
                    let _ = node.send(order);
                }
            }
        });
    }
}

/// A flag that Ctrl-C and a service manager's stop raise. The second Ctrl-C ends at once.
///
/// # Errors
/// The system takes no signal handler.
pub(super) fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .into_diagnostic()?;
    Ok(stop)
}
