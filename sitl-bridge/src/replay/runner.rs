//! A node, run again from its records.

use super::check::{ReplayCheck, ReplayReport};
use super::recording_info::{RecordingInfo, Role};
use crate::frame::{Encoder, Frame};
use crate::messages::{CommandLong, id, mav_cmd};
use crate::node::{HostTime, Node, NodeOutput};
use crate::tlog::{Note, NoteReader, Record};

/// The autopilot's component.
const AUTOPILOT: u8 = 1;
/// MAV_RESULT_ACCEPTED.
const ACCEPTED: u8 = 0;
/// Longest time between two turns of the node, µs: in flight it waits no longer for a datagram.
const TURN_US: u64 = 20_000;
/// A longer gap is a host's clock that was set, not time that passed, µs.
const LONGEST_GAP_US: u64 = 3_600_000_000;

/// Runs a node from its records.
#[derive(Debug)]
pub struct Replay<'a> {
    node: Node<'a>,
    info: RecordingInfo,
    check: ReplayCheck,
    out: NodeOutput,
    notes: NoteReader,
    /// Answers for the autopilot where the recording has none.
    autopilot: Encoder,
    /// Time of the last record, and time that passed since the first, µs.
    time_us: Option<(u64, u64)>,
}

impl<'a> Replay<'a> {
    /// `node` has the settings of the flight and has heard nothing yet.
    #[must_use]
    pub fn new(node: Node<'a>, info: RecordingInfo, check: ReplayCheck) -> Self {
        let (notes, autopilot) = (NoteReader::default(), Encoder::new(info.vehicle, AUTOPILOT));
        Self { node, info, check, out: NodeOutput::default(), notes, autopilot, time_us: None }
    }

    /// Feeds the next record.
    pub fn feed(&mut self, record: &Record) {
        let frame = &record.frame;
        let role = self.info.role(frame);
        // What came in one datagram has one time, and the node's turn ends behind it. Its heartbeats and commands are
        // sent at the end of a turn, so one has ended before each of them, however close the times are.
        if role == Role::Sent || self.time_us.is_some_and(|(last_us, _)| last_us != record.unix_us) {
            self.turn();
        }
        let now = self.pass_time(record.unix_us);
        match role {
            Role::Setpoint => self.check.flown(frame),
            Role::Broadcast => self.check.told(frame),
            Role::Sent => self.turn(),
            Role::Swarm => self.node.receive_swarm(frame.bytes(), now, &mut self.out),
            Role::Autopilot => {
                self.node.receive_autopilot(frame.bytes(), now, &mut self.out);
            }
            Role::Note => match self.notes.take(frame) {
                Some(Note::Command(command)) => self.node.command(command),
                Some(Note::Epoch(epoch_ms)) => self.node.set_epoch(epoch_ms),
                Some(Note::Flight(_)) | None => {}
            },
        }
        self.collect();
    }

    /// The report, after the last record.
    #[must_use]
    pub fn finish(mut self) -> ReplayReport {
        self.turn();
        self.check.finish(&self.node.counters())
    }

    fn now(&self) -> Option<HostTime> {
        self.time_us.map(|(unix_us, passed_us)| HostTime { wall_ms: passed_us / 1000, unix_us })
    }

    /// The end of the node's turn at the time of the last record.
    fn turn(&mut self) {
        if let Some(now) = self.now() {
            self.node.tick(now, &mut self.out);
            self.collect();
        }
    }

    /// The node's turns up to a recorded time. Where the host's clock was set, no time passed.
    fn pass_time(&mut self, unix_us: u64) -> HostTime {
        let (mut at_us, mut passed_us) = self.time_us.unwrap_or((unix_us, 0));
        let gap_us = unix_us.checked_sub(at_us).filter(|&gap| gap <= LONGEST_GAP_US).unwrap_or(0);
        let until_us = passed_us + gap_us;
        while until_us - passed_us > TURN_US {
            (at_us, passed_us) = (at_us + TURN_US, passed_us + TURN_US);
            self.time_us = Some((at_us, passed_us));
            self.turn();
        }
        self.time_us = Some((unix_us, until_us));
        HostTime { wall_ms: until_us / 1000, unix_us }
    }

    fn collect(&mut self) {
        for decision in &self.out.decisions {
            if let Some(profile) = self.node.velocity_profile() {
                self.check.decided(decision, profile);
            }
        }
        self.out.to_swarm.iter().for_each(|frame| self.check.rebroadcast(frame));
        self.out.to_autopilot.iter().for_each(|frame| self.check.replayed_setpoint(frame));
        let unasked = self.out.to_autopilot.iter().filter(|frame| self.was_never_asked(frame)).count();
        self.out.clear();
        for _ in 0..unasked {
            self.accept_request();
        }
    }

    /// Whether this asks for a message that the recorded node, of an earlier version, did not ask for: nobody answered
    /// it.
    fn was_never_asked(&self, frame: &Frame) -> bool {
        let asked = &self.info.requested;
        !asked.is_empty()
            && frame.message_id() == id::COMMAND_LONG
            && CommandLong::read(frame.payload()).requested_message().is_some_and(|message| !asked.contains(&message))
    }

    /// Answers a request as the autopilot would have, so that nothing waits for it.
    fn accept_request(&mut self) {
        let payload = [&mav_cmd::SET_MESSAGE_INTERVAL.to_le_bytes()[..], &[ACCEPTED]].concat();
        if let (Some(now), Ok(ack)) = (self.now(), self.autopilot.encode_payload(id::COMMAND_ACK, &payload)) {
            self.node.receive_autopilot(ack.bytes(), now, &mut self.out);
            self.collect();
        }
    }
}
