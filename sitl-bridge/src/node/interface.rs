//! What goes into a node and what comes out.

use super::record::{Decision, StepBegun};
use crate::autopilot::{Notice, Stage};
use crate::frame::Frame;
use crate::signing::Timestamp;
use firmware_core::gate::{Reason, Verdict};
use firmware_core::geometry::State;

/// The host's clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Now {
    /// Monotonic, ms.
    pub wall_ms: u64,
    /// Unix time, µs.
    pub unix_us: u64,
}

impl Now {
    pub(super) const fn timestamp(self) -> Timestamp {
        Timestamp::from_unix_us(self.unix_us)
    }
}

/// What a node wants done. Cleared by whoever did it.
#[derive(Debug, Default)]
pub struct Outbox {
    /// Frames for the swarm, to be sent first: a simulator in lock-step goes on once the
    /// autopilot's have arrived.
    pub to_swarm: Vec<Frame>,
    /// Frames for the autopilot.
    pub to_autopilot: Vec<Frame>,
    /// Frames that were believed, for a recording.
    pub heard: Vec<Frame>,
    /// For the operator.
    pub notices: Vec<Notice>,
    /// Steps that began.
    pub begun: Vec<StepBegun>,
    /// Decisions that were made.
    pub decisions: Vec<Decision>,
}

impl Outbox {
    /// Empties it.
    pub fn clear(&mut self) {
        self.to_swarm.clear();
        self.to_autopilot.clear();
        self.heard.clear();
        self.notices.clear();
        self.begun.clear();
        self.decisions.clear();
    }
}

/// A look at a node, for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Its id.
    pub id: u16,
    /// How far it is.
    pub stage: Stage,
    /// Flight mode in the users' words.
    pub mode: String,
    /// The gate's last verdict, one word, and its reason.
    pub gate: &'static str,
    /// See `gate`.
    pub reason: Option<Reason>,
    /// Where it is, ticks.
    pub state: Option<State>,
    /// Altitude above the mission's origin, m.
    pub altitude_m: Option<f64>,
    /// Step under way.
    pub step: Option<u32>,
    /// Age of the last word of the autopilot, ms of the host's clock.
    pub link_ms: Option<u64>,
    /// Age of the last word of another UAV, ms of the host's clock.
    pub swarm_ms: Option<u64>,
    /// Neighbours known and in view.
    pub neighbours: (usize, usize),
    /// Battery left, percent.
    pub battery: Option<u8>,
}

/// What an operator can ask of a node in flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// Take the vehicle (again), bring it up if need be, and fly.
    Start,
    /// Let it go: no more setpoints.
    Release,
    /// Let it return home.
    Return,
    /// Let it land on the spot.
    Land,
}

/// What the gate's verdict means for the flight.
pub(super) fn in_words(before: Verdict, verdict: Verdict) -> Notice {
    let flew = matches!(before, Verdict::Stream(_));
    let (text, warning) = match verdict {
        Verdict::Silent(reason) => (format!("no setpoints: {}", reason.name()), flew),
        Verdict::BringUp(_) => ("ready to start".into(), false),
        Verdict::Stream(_) => ("the actor flies".into(), false),
        Verdict::Hold(reason, _) => (format!("holding the place: {}", reason.name()), flew),
        Verdict::Return(reason) => (format!("asking the autopilot to return home: {}", reason.name()), true),
    };
    Notice { warning, text }
}
