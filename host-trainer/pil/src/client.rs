//! The client: one method for each request of the protocol.

use crate::answers::{BoardReport, HearOutcome, Observed};
use crate::convert::{board, decided, heard, in_view, observe_request, observed, read};
use crate::error::PilError;
use crate::exchange::{Exchange, Options, name};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::Moment;
use firmware_core::pil::{Decided, Hear, MAX_CASES, Reply, Request, RequestError, Setup, Status};
use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// How long a read of a socket blocks; deadlines are kept to about this.
const TICK: Duration = Duration::from_millis(10);

/// The host's end of the PIL protocol, over the stream `S` to one board.
#[derive(Debug)]
pub struct Client<S> {
    pub(crate) exchange: Exchange<S>,
}

impl Client<TcpStream> {
    /// Connects over TCP, for example to the serial port of an emulator.
    ///
    /// # Errors
    /// [`PilError::Io`] when nothing listens there.
    pub fn tcp(address: impl ToSocketAddrs, options: Options) -> Result<Self, PilError> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(TICK))?;
        stream.set_write_timeout(Some(options.timeout.max(TICK)))?;
        Ok(Self::new(stream, options))
    }
}

#[cfg(unix)]
impl Client<std::os::unix::net::UnixStream> {
    /// Connects over a Unix socket.
    ///
    /// # Errors
    /// [`PilError::Io`] when nothing listens there.
    pub fn unix(path: impl AsRef<std::path::Path>, options: Options) -> Result<Self, PilError> {
        let stream = std::os::unix::net::UnixStream::connect(path)?;
        stream.set_read_timeout(Some(TICK))?;
        stream.set_write_timeout(Some(options.timeout.max(TICK)))?;
        Ok(Self::new(stream, options))
    }
}

impl<S: Read + Write> Client<S> {
    /// A client over any stream, for example an open serial port. Its reads must return by themselves (`WouldBlock` or
    /// `TimedOut`) when nothing arrives; otherwise time-outs cannot be kept.
    pub const fn new(stream: S, options: Options) -> Self {
        Self { exchange: Exchange::new(stream, options) }
    }

    /// The stream to the board.
    pub const fn stream(&self) -> &S {
        self.exchange.stream()
    }

    /// Time-out and attempts of a request.
    pub const fn options(&self) -> Options {
        self.exchange.options()
    }

    /// Changes time-out and attempts of a request.
    pub const fn set_options(&mut self, options: Options) {
        self.exchange.set_options(options);
    }

    /// Number of frames of the board that arrived corrupted so far.
    pub const fn dropped(&self) -> u64 {
        self.exchange.dropped()
    }

    /// The report that the board sent by itself since the last call: it has started, or restarted.
    pub fn restarted(&mut self) -> Option<BoardReport> {
        match postcard::from_bytes(&self.exchange.take_unasked()?) {
            Ok(Reply::Report(report)) => Some(report.into()),
            _ => None,
        }
    }

    /// Sets the board up as one UAV of a swarm; its neighbour table starts empty. The first request of a flight.
    ///
    /// # Errors
    /// See [`PilError`]; [`RequestError::Actor`] when the board has no sound actor.
    pub fn hello(&mut self, setup: Setup) -> Result<BoardReport, PilError> {
        self.ask(&Request::Hello(setup), board)
    }

    /// Lets the board run its self-test again.
    ///
    /// # Errors
    /// As [`Self::hello`].
    pub fn self_test(&mut self) -> Result<BoardReport, PilError> {
        self.ask(&Request::SelfTest, board)
    }

    /// Passes on a neighbour's message that was received at `now`, with the UAV's own position (ticks) at that time.
    ///
    /// # Errors
    /// See [`PilError`].
    pub fn hear(&mut self, now: Moment, own_position: Vec2, message: &Message) -> Result<HearOutcome, PilError> {
        self.hear_bytes(now, own_position, message.encode(&mut [0; MAX_LEN]))
    }

    /// Passes on bytes that may be a neighbour's message; otherwise [`Self::hear`].
    ///
    /// # Errors
    /// See [`PilError`]; [`RequestError::Message`] when they are no message.
    pub fn hear_bytes(&mut self, now: Moment, own_position: Vec2, message: &[u8]) -> Result<HearOutcome, PilError> {
        if message.len() > MAX_LEN {
            return Err(PilError::Refused(RequestError::Message));
        }
        let position = [own_position.x, own_position.y];
        self.ask(&Request::Hear(Hear { now, position, message }), heard)
    }

    /// Lets the board observe and encode the step `now` from its own state and the PoIs (positions in ticks; those out
    /// of view are left out). Call it after the beacons of the step.
    ///
    /// # Errors
    /// See [`PilError`]; [`PilError::TooManyPois`] when more than [`firmware_core::pil::MAX_POIS`] are in view.
    pub fn observe(
        &mut self,
        now: Moment,
        own: State,
        pois: impl IntoIterator<Item = Vec2>,
    ) -> Result<Observed, PilError> {
        let pois = in_view(own.position, pois)?;
        self.ask(&observe_request(now, own, &pois), |reply| observed(now.step, reply))
    }

    /// Lets the board decide on the action of the step that it observed last. Call it after the features of the step.
    ///
    /// # Errors
    /// See [`PilError`]; [`RequestError::NotObserved`] when that was another step.
    pub fn decide(&mut self, step: u32) -> Result<Decided, PilError> {
        self.ask(&Request::Decide { step }, |reply| decided(step, reply))
    }

    /// Counters of the board and of the line to it.
    ///
    /// # Errors
    /// See [`PilError`].
    pub fn status(&mut self) -> Result<Status, PilError> {
        self.ask(&Request::Status, |reply| match reply {
            Reply::Status(status) => Some(Ok(status)),
            _ => None,
        })
    }

    /// The fingerprint of the board's actor over its first `cases` neighbourhoods (see
    /// [`firmware_core::actor::fingerprint`]), computed `chunk` cases at a time so that a slow board answers within the
    /// time-out. `progress` is called with the number of cases done.
    ///
    /// # Errors
    /// See [`PilError`]; [`PilError::LostCount`] when the board restarted meanwhile.
    pub fn fingerprint(&mut self, cases: u32, chunk: u16, mut progress: impl FnMut(u32)) -> Result<u64, PilError> {
        let chunk = chunk.clamp(1, MAX_CASES);
        let mut from = 0;
        loop {
            let add = (cases - from).min(u32::from(chunk)) as u16;
            let request = Request::Sign { from, cases: add };
            let (done, value) = self.ask(&request, |reply| match reply {
                Reply::Signature { cases, value } => Some(Ok((cases, value))),
                _ => None,
            })?;
            // A repeated request after a lost answer adds no cases, so the count is the same.
            if done != from + u32::from(add) {
                return Err(PilError::LostCount(done));
            }
            from = done;
            progress(from);
            if from >= cases {
                return Ok(value);
            }
        }
    }

    /// Sends a request and converts its answer with `pick`.
    fn ask<T>(
        &mut self,
        request: &Request<'_>,
        pick: impl FnOnce(Reply<'_>) -> Option<Result<T, PilError>>,
    ) -> Result<T, PilError> {
        let record = self.exchange.ask(request)?;
        read(&record, name(request), pick)
    }
}
