//! The event loop around a node: one thread that receives, runs the node and sends in turn.

use super::control::{Links, RunControl};
use super::event::NodeEvent;
use crate::autopilot::{Notice, Stage};
use crate::connection::{RECEIVE_LEN, Received, Sent, wait};
use crate::node::host_time::HostTime;
use crate::node::operator::OperatorCommand;
use crate::node::output::NodeOutput;
use crate::node::state_machine::Node;
use crate::swarm_link::SwarmSocket;
use crate::tlog::Note;
use std::io;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, Sender};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Most datagrams received from the autopilot in a turn. The rest waits in the kernel's bounded
/// queue, so a flood cannot keep the node from its own work.
const AUTOPILOT_PER_TURN: usize = 32;
/// Most datagrams received from the swarm before one of the autopilot is handled.
const SWARM_PER_TURN: usize = 64;
/// Longest wait for a datagram.
const WAIT: Duration = Duration::from_millis(20);
/// Between two [`NodeEvent::Status`], ms.
const STATUS_MS: u64 = 500;
/// How long the end of the flight may take, ms: braking, or the COMMAND_ACK of a landing.
const ENDING_MS: u64 = 4000;
/// Errors of a link are reported this often, ms.
const ERROR_MS: u64 = 10_000;

/// Flies until `control` stops it. Events are sent with the node's `index`.
///
/// # Errors
/// Waiting for the links fails. Errors of a single link are reported as events, and the flight goes on.
pub fn run(
    node: &mut Node<'_>,
    mut links: Links,
    control: &RunControl,
    index: usize,
    events: &Sender<(usize, NodeEvent)>,
) -> io::Result<()> {
    let mut event_loop = EventLoop {
        index,
        events,
        began: Instant::now(),
        out: NodeOutput::default(),
        buffer: vec![0; RECEIVE_LEN],
        stage: node.stage(),
        status_ms: 0,
        error_ms: 0,
        epoch_ms: RunControl::OWN_EPOCH,
    };
    event_loop.begin_recording(node, &mut links, control);
    while !control.stop.load(Ordering::Relaxed) {
        event_loop.update_epoch(node, &mut links, control);
        for command in control.commands.iter().flat_map(Receiver::try_iter) {
            event_loop.command(node, &mut links, command);
        }
        event_loop.run_turn(node, &mut links)?;
    }
    let parting = if control.land { OperatorCommand::Land } else { OperatorCommand::Release };
    event_loop.command(node, &mut links, parting);
    let until = event_loop.now().wall_ms + if control.brake { ENDING_MS } else { 0 };
    loop {
        event_loop.run_turn(node, &mut links)?;
        if !node.is_ending() || event_loop.now().wall_ms >= until {
            break;
        }
    }
    event_loop.report(NodeEvent::Ended(Box::new(node.counters())));
    Ok(())
}

struct EventLoop<'r> {
    index: usize,
    events: &'r Sender<(usize, NodeEvent)>,
    began: Instant,
    out: NodeOutput,
    buffer: Vec<u8>,
    stage: Stage,
    status_ms: u64,
    error_ms: u64,
    epoch_ms: i64,
}

impl EventLoop<'_> {
    /// Notes at the beginning of a recording what is flown, and from when steps are counted.
    fn begin_recording(&self, node: &Node<'_>, links: &mut Links, control: &RunControl) {
        if links.tlog.is_some() {
            self.note(node, links, &Note::Flight(node.settings.flight()));
            if control.epoch_ms.load(Ordering::Relaxed) == RunControl::OWN_EPOCH {
                self.note(node, links, &Note::Epoch(Some(node.settings.mission.epoch_unix_ms)));
            }
        }
    }

    fn update_epoch(&mut self, node: &mut Node<'_>, links: &mut Links, control: &RunControl) {
        let epoch_ms = control.epoch_ms.load(Ordering::Relaxed);
        if epoch_ms != self.epoch_ms {
            self.epoch_ms = epoch_ms;
            let epoch_ms = (epoch_ms != RunControl::NO_EPOCH).then_some(epoch_ms);
            self.note(node, links, &Note::Epoch(epoch_ms));
            node.set_epoch(epoch_ms);
        }
    }

    /// Carries out a command, and notes it in the recording, so that a replay carries it out too.
    fn command(&self, node: &mut Node<'_>, links: &mut Links, command: OperatorCommand) {
        self.note(node, links, &Note::Command(command));
        node.command(command);
    }

    fn note(&self, node: &Node<'_>, links: &mut Links, note: &Note) {
        if let Some(tlog) = &mut links.tlog {
            tlog.note(self.now().unix_us, node.settings.system, note);
        }
    }

    /// One turn: waits, receives from both links, runs the node, sends.
    fn run_turn(&mut self, node: &mut Node<'_>, links: &mut Links) -> io::Result<()> {
        let watched: Vec<_> =
            links.autopilot.watch().into_iter().chain(links.swarm.as_ref().map(SwarmSocket::watch)).collect();
        wait(&watched, WAIT)?;
        self.receive_swarm(node, links);
        for _ in 0..AUTOPILOT_PER_TURN {
            let received = match links.autopilot.recv(&mut self.buffer) {
                Ok(received) => received,
                Err(error) => {
                    self.report_error("the autopilot's link", &error);
                    break;
                }
            };
            match received {
                Received::Nothing => break,
                Received::Bytes { len, peer } => {
                    let datagram = self.buffer[..len].to_vec();
                    // In lock-step, the messages of the other UAVs about the last tick have arrived by now.
                    self.receive_swarm(node, links);
                    let now = self.now();
                    if node.receive_autopilot(&datagram, now, &mut self.out) {
                        links.autopilot.confirm(peer);
                    }
                    self.flush(links);
                }
                Received::Connected => {
                    node.reconnected();
                    self.notify(Notice::info("the autopilot's link is up"));
                }
                Received::Lost(error) => self.notify(Notice::warning(format!("the autopilot's link broke: {error}"))),
            }
        }
        let now = self.now();
        node.tick(now, &mut self.out);
        self.flush(links);
        self.report_status(node, now);
        Ok(())
    }

    fn receive_swarm(&mut self, node: &mut Node<'_>, links: &mut Links) {
        let Some(socket) = &mut links.swarm else { return };
        // A buffer of its own: the other one may hold a datagram that is not handled yet.
        let mut buffer = [0; RECEIVE_LEN];
        for _ in 0..SWARM_PER_TURN {
            match socket.recv(&mut buffer) {
                Ok(Some(len)) => {
                    let now = self.now();
                    node.receive_swarm(&buffer[..len], now, &mut self.out);
                }
                Ok(None) => break,
                Err(error) => {
                    self.report_error("the swarm's link", &error);
                    break;
                }
            }
        }
    }

    /// Sends and reports what the node returned.
    fn flush(&mut self, links: &mut Links) {
        let mut errors = Vec::new();
        if let Some(socket) = &mut links.swarm {
            for frame in &self.out.to_swarm {
                errors.extend(socket.send(frame.bytes()).err().map(|e| ("the swarm's link", e)));
            }
        }
        for frame in &self.out.to_autopilot {
            match links.autopilot.send(frame.bytes()) {
                Ok(Sent::Yes | Sent::NoPeer | Sent::Full) => {}
                Err(error) => errors.push(("the autopilot's link", error)),
            }
        }
        if let Some(tlog) = &mut links.tlog {
            let unix_us = self.now().unix_us;
            for frame in self.out.received.iter().chain(&self.out.to_swarm).chain(&self.out.to_autopilot) {
                tlog.record(unix_us, frame);
            }
            if let Some(error) = tlog.take_error() {
                errors.push(("the recording", error));
            }
        }
        for (what, error) in errors {
            self.report_error(what, &error);
        }
        for notice in std::mem::take(&mut self.out.notices) {
            self.report(NodeEvent::Notice(notice));
        }
        for step in std::mem::take(&mut self.out.steps) {
            self.report(NodeEvent::StepStarted(step));
        }
        for decision in std::mem::take(&mut self.out.decisions) {
            self.report(NodeEvent::Decision(decision));
        }
        self.out.clear();
    }

    fn report_status(&mut self, node: &Node<'_>, now: HostTime) {
        let stage = node.stage();
        let due = now.wall_ms >= self.status_ms;
        if let Some(common_ms) = node.common_ms().filter(|_| stage != self.stage || due) {
            self.report(NodeEvent::Clock(common_ms));
        }
        if stage != self.stage {
            self.stage = stage;
            self.report(NodeEvent::Stage(stage));
        }
        if due {
            self.status_ms = now.wall_ms + STATUS_MS;
            self.report(NodeEvent::Status(Box::new(node.status(now))));
        }
    }

    fn report_error(&mut self, what: &str, error: &io::Error) {
        let now_ms = self.now().wall_ms;
        if now_ms >= self.error_ms {
            self.error_ms = now_ms + ERROR_MS;
            self.notify(Notice::warning(format!("{what}: {error}")));
        }
    }

    fn notify(&self, notice: Notice) {
        self.report(NodeEvent::Notice(notice));
    }

    fn report(&self, event: NodeEvent) {
        // The receiver may have ended before the node.
        let _ = self.events.send((self.index, event));
    }

    fn now(&self) -> HostTime {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        HostTime {
            wall_ms: u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX),
            unix_us: u64::try_from(unix.as_micros()).unwrap_or(u64::MAX),
        }
    }
}
