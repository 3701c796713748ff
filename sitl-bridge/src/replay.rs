//! A recorded flight, decided again.
//!
//! What a node heard is fed from its tlog to a node of the same kind, at the recorded times; what
//! it then sends is held against what was sent. Decisions stand in the log by their setpoints: of
//! the flights that the 17 actions would have asked for, the nearest names the action that was
//! flown. A step's feature is there word for word, and tells what the UAV saw. What the operator
//! asked for is obeyed again where the log has it.
//!
//! ```text
//! Survey    who is who in the log: which frames the node sent, which it heard, what it was set to
//! Replay    the node, run again
//! Judge     its decisions against those that were flown
//! ```

mod judge;
mod stream;
mod survey;

pub use judge::{Account, Difference, Judge, Kind};
pub use stream::{Foreign, foreign};
pub use survey::{Role, Survey, SurveyError};

use crate::node::{Node, Now, Outbox};
use crate::tlog::{Note, NoteReader, Record};

/// Longest time between two turns of the node, µs: in flight it waits no longer for a datagram.
const TURN_US: u64 = 20_000;
/// A longer gap is a host's clock that was set, not time that passed, µs.
const LONGEST_GAP_US: u64 = 3_600_000_000;

/// Runs a node from its records.
#[derive(Debug)]
pub struct Replay<'a> {
    node: Node<'a>,
    survey: Survey,
    judge: Judge,
    out: Outbox,
    notes: NoteReader,
    /// Time of the last record, and time that passed since the first, µs.
    time_us: Option<(u64, u64)>,
}

impl<'a> Replay<'a> {
    /// `node` has the settings of the flight and has heard nothing yet.
    #[must_use]
    pub fn new(node: Node<'a>, survey: Survey, judge: Judge) -> Self {
        let notes = NoteReader::default();
        Self { node, survey, judge, out: Outbox::default(), notes, time_us: None }
    }

    /// Takes in the next record.
    pub fn take(&mut self, record: &Record) {
        let frame = &record.frame;
        let role = self.survey.role(frame);
        // What came in one datagram has one time, and the node's turn ends behind it. Its heartbeats and commands are
        // sent at the end of a turn, so one has ended before each of them, however close the times are.
        if role == Role::Sent || self.time_us.is_some_and(|(last_us, _)| last_us != record.unix_us) {
            self.turn();
        }
        let now = self.pass_time(record.unix_us);
        match role {
            Role::Setpoint => self.judge.flown(frame),
            Role::Told => self.judge.told(frame),
            Role::Sent => self.turn(),
            Role::Swarm => self.node.hear_swarm(frame.bytes(), now, &mut self.out),
            Role::Autopilot => {
                self.node.hear_autopilot(frame.bytes(), now, &mut self.out);
            }
            Role::Note => match self.notes.take(frame) {
                Some(Note::Order(order)) => self.node.obey(order),
                Some(Note::Epoch(epoch_ms)) => self.node.set_epoch(epoch_ms),
                Some(Note::Flight(_)) | None => {}
            },
        }
        self.collect();
    }

    /// The account, after the last record.
    #[must_use]
    pub fn finish(mut self) -> Account {
        self.turn();
        self.judge.finish(&self.node.counters())
    }

    fn now(&self) -> Option<Now> {
        self.time_us.map(|(unix_us, passed_us)| Now { wall_ms: passed_us / 1000, unix_us })
    }

    /// The end of the node's turn at the time of the last record.
    fn turn(&mut self) {
        if let Some(now) = self.now() {
            self.node.tick(now, &mut self.out);
            self.collect();
        }
    }

    /// The node's turns up to a recorded time. Where the host's clock was set, no time passed.
    fn pass_time(&mut self, unix_us: u64) -> Now {
        let (mut at_us, mut passed_us) = self.time_us.unwrap_or((unix_us, 0));
        let gap_us = unix_us.checked_sub(at_us).filter(|&gap| gap <= LONGEST_GAP_US).unwrap_or(0);
        let until_us = passed_us + gap_us;
        while until_us - passed_us > TURN_US {
            (at_us, passed_us) = (at_us + TURN_US, passed_us + TURN_US);
            self.time_us = Some((at_us, passed_us));
            self.turn();
        }
        self.time_us = Some((unix_us, until_us));
        Now { wall_ms: until_us / 1000, unix_us }
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
