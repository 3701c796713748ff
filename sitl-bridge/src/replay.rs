//! A recorded flight, decided again.
//!
//! What a node heard is fed from its tlog to a node of the same kind, at the recorded times; what
//! it then sends is held against what was sent. Decisions stand in the log by their setpoints: of
//! the flights that the 17 actions would have asked for, the nearest names the action that was
//! flown. A step's feature is in the log byte for byte, and depends on all that the UAV observed.
//!
//! ```text
//! RecordingInfo   which frames of the log the node sent, and which it received
//! Replay          the node, run again
//! ReplayCheck     its decisions against those that were flown
//! ```

mod check;
mod recording_info;

pub use check::{Difference, DifferenceKind, ReplayCheck, ReplayReport};
pub use recording_info::{RecordingError, RecordingInfo, Role};

use crate::node::{HostTime, Node, NodeOutput};
use crate::tlog::Record;

/// Longest time without a turn of the node, ms: as in flight.
const TURN_MS: u64 = 50;
/// In a longer silence of the log nothing more happens, ms.
const LONGEST_SILENCE_MS: u64 = 60_000;

/// Runs a node from its records.
#[derive(Debug)]
pub struct Replay<'a> {
    node: Node<'a>,
    info: RecordingInfo,
    check: ReplayCheck,
    out: NodeOutput,
    now: Option<HostTime>,
}

impl<'a> Replay<'a> {
    /// `node` has the settings of the flight and has heard nothing yet.
    #[must_use]
    pub fn new(node: Node<'a>, info: RecordingInfo, check: ReplayCheck) -> Self {
        Self { node, info, check, out: NodeOutput::default(), now: None }
    }

    /// Feeds the next record.
    pub fn feed(&mut self, record: &Record) {
        let now = self.pass_time(record.unix_us);
        let frame = &record.frame;
        match self.info.role(frame) {
            Role::Setpoint => self.check.flown(frame),
            Role::Broadcast => self.check.told(frame),
            Role::Sent => {}
            Role::Swarm => self.node.receive_swarm(frame.bytes(), now, &mut self.out),
            Role::Autopilot => {
                self.node.receive_autopilot(frame.bytes(), now, &mut self.out);
            }
        }
        self.collect();
    }

    /// The report, after the last record.
    #[must_use]
    pub fn finish(mut self) -> ReplayReport {
        if let Some(now) = self.now {
            self.node.tick(now, &mut self.out);
            self.collect();
        }
        self.check.finish(&self.node.counters())
    }

    /// The node's turns up to a recorded time. A host's clock that was set back stands still.
    fn pass_time(&mut self, unix_us: u64) -> HostTime {
        let last = *self.now.get_or_insert(HostTime { wall_ms: 0, unix_us });
        if unix_us <= last.unix_us {
            return last;
        }
        let passed_ms = (unix_us - last.unix_us) / 1000;
        let mut now = last;
        for _ in 0..passed_ms.min(LONGEST_SILENCE_MS) / TURN_MS {
            now = HostTime { wall_ms: now.wall_ms + TURN_MS, unix_us: now.unix_us + TURN_MS * 1000 };
            self.node.tick(now, &mut self.out);
        }
        // Less than a millisecond waits for the next record.
        let rest_ms = (unix_us - now.unix_us) / 1000;
        now = HostTime { wall_ms: now.wall_ms + rest_ms, unix_us: now.unix_us + rest_ms * 1000 };
        if now != last {
            self.node.tick(now, &mut self.out);
            self.now = Some(now);
        }
        now
    }

    fn collect(&mut self) {
        for decision in &self.out.decisions {
            if let Some(profile) = self.node.velocity_profile() {
                self.check.decided(decision, profile);
            }
        }
        self.out.to_swarm.iter().for_each(|frame| self.check.rebroadcast(frame));
        self.out.to_autopilot.iter().for_each(|frame| self.check.replayed_setpoint(frame));
        self.out.clear();
    }
}
