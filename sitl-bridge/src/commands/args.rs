//! Arguments that several commands have in common.

use super::actor_file::ActorFileError;
use crate::node::StepTiming;
use crate::signing::{Key, LinkSigning, Session, StateFile, Timestamp, Unsigned};
use covey_env::open_actor;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
use std::path::{Path, PathBuf};

/// Which actor flies.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ActorArgs {
    /// The actor file; or gcn, gat or none: those that come with Covey [default: gcn].
    #[arg(long)]
    actor: Option<PathBuf>,
}

impl ActorArgs {
    /// Reads the actor file: its bytes and its name.
    pub fn read(&self) -> Result<(Vec<u8>, PathBuf), ActorFileError> {
        let path = || self.actor.clone().unwrap_or_default();
        let read = open_actor(self.actor.as_deref());
        read.map(|(bytes, name)| (bytes, name.into())).map_err(|source| ActorFileError::Read { path: path(), source })
    }
}

/// The phases of a step.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct TimingArgs {
    /// Positions asked of the autopilot, Hz; setpoints go out as often.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(2..=50))]
    rate_hz: u16,
    /// From a step's start until the UAV observes, encodes and broadcasts its feature at the latest, ms: as soon as all
    /// who are expected were heard it does so.
    #[arg(long, default_value_t = 400)]
    encode_ms: u16,
    /// From a step's start until the decision at the latest, ms: it is made as soon as the features of all who were
    /// observed arrived.
    #[arg(long, default_value_t = 800)]
    decide_ms: u16,
    /// A UAV counts as where its velocity takes it in this time, ms: vehicles are so much slower to change their velocity
    /// than the scenario's.
    #[arg(long, default_value_t = StepTiming::default().lead_ms, value_parser = clap::value_parser!(u16).range(0..=2000))]
    lead_ms: u16,
    /// Beacons a second; one at the start of each step when left out.
    #[arg(long)]
    beacon_hz: Option<f64>,
}

impl TimingArgs {
    /// Rate of positions, Hz.
    pub const fn rate_hz(&self) -> u16 {
        self.rate_hz
    }

    /// Whether all options were left out, or have their defaults.
    pub fn is_default(&self) -> bool {
        let StepTiming { encode_ms, decide_ms, lead_ms, .. } = StepTiming::default();
        (self.rate_hz, self.encode_ms, self.decide_ms, self.lead_ms, self.beacon_hz)
            == (5, encode_ms, decide_ms, lead_ms, None)
    }

    /// The phases, checked against the length of a step.
    pub fn timing(&self, step_ms: u16) -> Result<StepTiming> {
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
        let (encode_ms, decide_ms, lead_ms) = (self.encode_ms, self.decide_ms, self.lead_ms);
        Ok(StepTiming { encode_ms, decide_ms, beacon_ms, telemetry_ms, lead_ms, ..StepTiming::default() })
    }
}

/// Keys of MAVLink 2 signing.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct SigningArgs {
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
    /// Signing of the autopilot's link and of the swarm's link.
    pub fn links(&self) -> Result<(LinkSigning, LinkSigning)> {
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

    /// What a swarm's link without a key allows, for the operator; `None` with a key.
    pub const fn keyless_warning(&self) -> Option<&'static str> {
        if self.signing_key_file.is_some() || self.signing_key_env.is_some() {
            return None;
        }
        Some(
            "warning: the swarm's link has no key: whoever reaches its network can pose as a UAV and mislead this one's \
             decisions (--signing-key-file)",
        )
    }

    /// File with the key, if it is in one.
    pub fn key_file(&self) -> Option<&Path> {
        self.signing_key_file.as_deref()
    }

    /// The signing session of a node; each node of a process has its own state file.
    pub fn session(&self, id: Option<u16>) -> Result<Session> {
        let Some(path) = &self.signing_state else { return Ok(Session::new()) };
        let mut path = path.clone();
        if let Some(id) = id {
            path.as_mut_os_string().push(format!(".{id}"));
        }
        let state = StateFile::open(&path).into_diagnostic()?;
        Session::with_state(state, Timestamp::now()).into_diagnostic().wrap_err("signatures have no time")
    }
}
