//! Sockets around a node: one thread that does everything in turn.

use super::{Counters, Decision, Node, Now, Order, Outbox, Status, StepBegun};
use crate::autopilot::{Notice, Stage};
use crate::connection::{Connection, RECEIVE_LEN, Received, Sent, wait};
use crate::swarm_link::SwarmSocket;
use crate::tlog::{Note, TlogWriter};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::{Receiver, Sender};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Most datagrams taken from the autopilot in a turn. What waits longer is in the kernel's
/// bounded queue, so a flood cannot keep the node from its own work.
const AUTOPILOT_A_TURN: usize = 32;
/// Most datagrams taken from the swarm before one of the autopilot is acted on.
const SWARM_A_TURN: usize = 64;
/// Longest wait for a datagram, ms.
const WAIT: Duration = Duration::from_millis(20);
/// Between two reports of the status, ms.
const STATUS_MS: u64 = 500;
/// A landing has this long to be taken at the end, ms.
const LANDING_MS: u64 = 3000;
/// Errors of a socket are told this often, ms.
const ERROR_MS: u64 = 10_000;

/// A node's links.
#[derive(Debug)]
pub struct Links {
    /// To the autopilot.
    pub autopilot: Connection,
    /// To the swarm; a UAV can fly alone.
    pub swarm: Option<SwarmSocket>,
    /// A recording of both.
    pub tlog: Option<TlogWriter>,
}

/// What others do to a running node.
#[derive(Debug)]
pub struct Control {
    /// Ends the flight.
    pub stop: Arc<AtomicBool>,
    /// Asks for a landing at the end.
    pub land: bool,
    /// When step 0 begins, Unix time in ms: [`Control::OWN_EPOCH`] the mission's,
    /// [`Control::NO_EPOCH`] never.
    pub epoch_ms: Arc<AtomicI64>,
    /// What the operator asks for.
    pub orders: Option<Receiver<Order>>,
}

impl Control {
    /// The mission's own epoch.
    pub const OWN_EPOCH: i64 = i64::MIN;
    /// No steps yet.
    pub const NO_EPOCH: i64 = i64::MAX;

    /// A control that ends with `stop`, by the mission's own epoch.
    #[must_use]
    pub fn new(stop: Arc<AtomicBool>, land: bool) -> Self {
        Self { stop, land, epoch_ms: Arc::new(AtomicI64::new(Self::OWN_EPOCH)), orders: None }
    }
}

/// What a running node tells.
#[derive(Clone, Debug)]
pub enum Report {
    /// For the operator.
    Notice(Notice),
    /// It got farther.
    Stage(Stage),
    /// Its common clock, Unix time in ms, told with each [`Report::Stage`] and [`Report::Status`].
    Clock(i64),
    /// A step began.
    Begun(StepBegun),
    /// It decided.
    Decision(Decision),
    /// How it stands, twice a second.
    Status(Box<Status>),
    /// It has ended.
    Ended(Box<Counters>),
}

/// Flies until it is told to stop. Reports go out with the node's `index`.
///
/// # Errors
/// The links cannot be waited on. Errors of a link alone are reported and borne.
pub fn run(
    node: &mut Node<'_>,
    mut links: Links,
    control: &Control,
    index: usize,
    reports: &Sender<(usize, Report)>,
) -> io::Result<()> {
    let mut turn = Turn {
        index,
        reports,
        began: Instant::now(),
        out: Outbox::default(),
        buffer: vec![0; RECEIVE_LEN],
        stage: node.stage(),
        status_ms: 0,
        error_ms: 0,
        epoch_ms: Control::OWN_EPOCH,
    };
    turn.begin_recording(node, &mut links, control);
    while !control.stop.load(Ordering::Relaxed) {
        turn.take_epoch(node, &mut links, control);
        for order in control.orders.iter().flat_map(Receiver::try_iter) {
            turn.obey(node, &mut links, order);
        }
        turn.pass(node, &mut links)?;
    }
    turn.obey(node, &mut links, if control.land { Order::Land } else { Order::Release });
    let until = turn.now().wall_ms + LANDING_MS;
    loop {
        turn.pass(node, &mut links)?;
        if !node.is_asking() || turn.now().wall_ms >= until {
            break;
        }
    }
    turn.report(Report::Ended(Box::new(node.counters())));
    Ok(())
}

struct Turn<'r> {
    index: usize,
    reports: &'r Sender<(usize, Report)>,
    began: Instant,
    out: Outbox,
    buffer: Vec<u8>,
    stage: Stage,
    status_ms: u64,
    error_ms: u64,
    epoch_ms: i64,
}

impl Turn<'_> {
    /// What is flown, and from when steps are counted, stand at the beginning of a recording.
    fn begin_recording(&self, node: &Node<'_>, links: &mut Links, control: &Control) {
        if links.tlog.is_some() {
            self.note(node, links, &Note::Flight(node.settings.flight()));
            if control.epoch_ms.load(Ordering::Relaxed) == Control::OWN_EPOCH {
                self.note(node, links, &Note::Epoch(Some(node.settings.mission.epoch_unix_ms)));
            }
        }
    }

    fn take_epoch(&mut self, node: &mut Node<'_>, links: &mut Links, control: &Control) {
        let epoch_ms = control.epoch_ms.load(Ordering::Relaxed);
        if epoch_ms != self.epoch_ms {
            self.epoch_ms = epoch_ms;
            let epoch_ms = (epoch_ms != Control::NO_EPOCH).then_some(epoch_ms);
            self.note(node, links, &Note::Epoch(epoch_ms));
            node.set_epoch(epoch_ms);
        }
    }

    /// Orders stand in the recording, so that a replay can obey them too.
    fn obey(&self, node: &mut Node<'_>, links: &mut Links, order: Order) {
        self.note(node, links, &Note::Order(order));
        node.obey(order);
    }

    fn note(&self, node: &Node<'_>, links: &mut Links, note: &Note) {
        if let Some(tlog) = &mut links.tlog {
            tlog.note(self.now().unix_us, node.settings.system, note);
        }
    }

    /// One turn: waits, receives from both sides, lets the node work, sends.
    fn pass(&mut self, node: &mut Node<'_>, links: &mut Links) -> io::Result<()> {
        let watched: Vec<_> =
            links.autopilot.watch().into_iter().chain(links.swarm.as_ref().map(SwarmSocket::watch)).collect();
        wait(&watched, WAIT)?;
        self.hear_swarm(node, links);
        for _ in 0..AUTOPILOT_A_TURN {
            let received = match links.autopilot.recv(&mut self.buffer) {
                Ok(received) => received,
                Err(error) => {
                    self.failed("the autopilot's link", &error);
                    break;
                }
            };
            match received {
                Received::Nothing => break,
                Received::Bytes { len, peer } => {
                    let datagram = self.buffer[..len].to_vec();
                    // In lock-step, what the others said about the last tick is there by now.
                    self.hear_swarm(node, links);
                    let now = self.now();
                    if node.hear_autopilot(&datagram, now, &mut self.out) {
                        links.autopilot.confirm(peer);
                    }
                    self.flush(links);
                }
                Received::Connected => {
                    node.reconnected();
                    self.tell(Notice::info("the autopilot's link is up"));
                }
                Received::Lost(error) => self.tell(Notice::warning(format!("the autopilot's link broke: {error}"))),
            }
        }
        let now = self.now();
        node.tick(now, &mut self.out);
        self.flush(links);
        self.look(node, now);
        Ok(())
    }

    fn hear_swarm(&mut self, node: &mut Node<'_>, links: &mut Links) {
        let Some(socket) = &mut links.swarm else { return };
        // A buffer of its own: the other may hold a datagram that waits.
        let mut buffer = [0; RECEIVE_LEN];
        for _ in 0..SWARM_A_TURN {
            match socket.recv(&mut buffer) {
                Ok(Some(len)) => {
                    let now = self.now();
                    node.hear_swarm(&buffer[..len], now, &mut self.out);
                }
                Ok(None) => break,
                Err(error) => {
                    self.failed("the swarm's link", &error);
                    break;
                }
            }
        }
    }

    /// Sends and reports what the node wants.
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
            for frame in self.out.heard.iter().chain(&self.out.to_swarm).chain(&self.out.to_autopilot) {
                tlog.record(unix_us, frame);
            }
            if let Some(error) = tlog.take_error() {
                errors.push(("the recording", error));
            }
        }
        for (what, error) in errors {
            self.failed(what, &error);
        }
        for notice in std::mem::take(&mut self.out.notices) {
            self.report(Report::Notice(notice));
        }
        for begun in std::mem::take(&mut self.out.begun) {
            self.report(Report::Begun(begun));
        }
        for decision in std::mem::take(&mut self.out.decisions) {
            self.report(Report::Decision(decision));
        }
        self.out.clear();
    }

    fn look(&mut self, node: &Node<'_>, now: Now) {
        let stage = node.stage();
        let due = now.wall_ms >= self.status_ms;
        if let Some(common_ms) = node.common_ms().filter(|_| stage != self.stage || due) {
            self.report(Report::Clock(common_ms));
        }
        if stage != self.stage {
            self.stage = stage;
            self.report(Report::Stage(stage));
        }
        if due {
            self.status_ms = now.wall_ms + STATUS_MS;
            self.report(Report::Status(Box::new(node.status(now))));
        }
    }

    fn failed(&mut self, what: &str, error: &io::Error) {
        let now_ms = self.now().wall_ms;
        if now_ms >= self.error_ms {
            self.error_ms = now_ms + ERROR_MS;
            self.tell(Notice::warning(format!("{what}: {error}")));
        }
    }

    fn tell(&self, notice: Notice) {
        self.report(Report::Notice(notice));
    }

    fn report(&self, report: Report) {
        // Nobody listens any more once the flight is over.
        let _ = self.reports.send((self.index, report));
    }

    fn now(&self) -> Now {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Now {
            wall_ms: u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX),
            unix_us: u64::try_from(unix.as_micros()).unwrap_or(u64::MAX),
        }
    }
}
