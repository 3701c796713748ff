//! A recorded flight, decided again.
//!
//! What a node heard is fed from its tlog to a node of the same kind, at the recorded times; what
//! it then sends is held against what was sent. Decisions stand in the log by their setpoints: of
//! the flights that the 17 actions would have asked for, the nearest names the action that was
//! flown. A step's feature is there word for word, and tells what the UAV saw.
//!
//! ```text
//! Survey    who is who in the log: which frames the node sent, which it heard
//! Replay    the node, run again
//! Judge     its decisions against those that were flown
//! ```

mod judge;
mod survey;

pub use judge::{Account, Difference, Judge, Kind};
pub use survey::{Role, Survey, SurveyError};

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
    survey: Survey,
    judge: Judge,
    out: NodeOutput,
    now: Option<HostTime>,
}

impl<'a> Replay<'a> {
    /// `node` has the settings of the flight and has heard nothing yet.
    #[must_use]
    pub fn new(node: Node<'a>, survey: Survey, judge: Judge) -> Self {
        Self { node, survey, judge, out: NodeOutput::default(), now: None }
    }

    /// Takes in the next record.
    pub fn take(&mut self, record: &Record) {
        let now = self.pass_time(record.unix_us);
        let frame = &record.frame;
        match self.survey.role(frame) {
            Role::Setpoint => self.judge.flown(frame),
            Role::Told => self.judge.told(frame),
            Role::Sent => {}
            Role::Swarm => self.node.receive_swarm(frame.bytes(), now, &mut self.out),
            Role::Autopilot => {
                self.node.receive_autopilot(frame.bytes(), now, &mut self.out);
            }
        }
        self.collect();
    }

    /// The account, after the last record.
    #[must_use]
    pub fn finish(mut self) -> Account {
        if let Some(now) = self.now {
            self.node.tick(now, &mut self.out);
            self.collect();
        }
        self.judge.finish(&self.node.counters())
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
            if let Some(plan) = self.node.plan() {
                self.judge.decided(decision, plan);
            }
        }
        self.out.to_swarm.iter().for_each(|frame| self.judge.told_again(frame));
        self.out.to_autopilot.iter().for_each(|frame| self.judge.flown_again(frame));
        self.out.clear();
    }
}
