//! The requests, with the types of a host.

use crate::PilError;
use crate::exchange::{Exchange, Options, name};
use crate::records::{board, decided, heard, in_view, observe_request, observed, read};
use firmware_core::geometry::{State, Vec2};
use firmware_core::message::{MAX_LEN, Message};
use firmware_core::neighbour_table::{MessageOutcome, Moment};
use firmware_core::pil::{
    ActorError, ActorInfo, Decided, Hear, MAX_CASES, Reply, Report, Request, RequestError, Setup, Status,
};
use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// How long a read of a socket blocks; deadlines are kept to about this.
const TICK: Duration = Duration::from_millis(10);

/// What a board said about itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Board {
    /// Version of its firmware.
    pub software: String,
    /// Its actor, or why it has none that may fly.
    pub actor: Result<ActorInfo, ActorError>,
}

impl From<Report<'_>> for Board {
    fn from(r: Report<'_>) -> Self {
        Self { software: r.software.to_owned(), actor: r.actor }
    }
}

/// What became of a neighbour's message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// What became of the message. [`MessageOutcome::Repeated`] may mean that the first attempt's answer was lost.
    pub outcome: MessageOutcome,
    /// UAVs in the table now.
    pub kept: u8,
}

/// An observed step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Observed {
    /// Neighbours in view and the UAV itself, 1 to 17.
    pub degree: u8,
    /// The UAV's tie-breaker of the step.
    pub tie: i8,
    /// The feature message to broadcast; empty when the policy broadcasts none.
    pub message: Vec<u8>,
}

/// The host's end of the PIL protocol.
#[derive(Debug)]
pub struct Client<S> {
    pub(crate) exchange: Exchange<S>,
}

impl Client<TcpStream> {
    /// Over TCP, as an emulator's serial port offers it.
    ///
    /// # Errors
    /// [`PilError::Io`] when nobody listens there.
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
    /// Over a Unix socket.
    ///
    /// # Errors
    /// [`PilError::Io`] when nobody listens there.
    pub fn unix(path: impl AsRef<std::path::Path>, options: Options) -> Result<Self, PilError> {
        let stream = std::os::unix::net::UnixStream::connect(path)?;
        stream.set_read_timeout(Some(TICK))?;
        stream.set_write_timeout(Some(options.timeout.max(TICK)))?;
        Ok(Self::new(stream, options))
    }
}

impl<S: Read + Write> Client<S> {
    /// Over any stream, for example an open serial port. A read must give up by itself
    /// (`WouldBlock` or `TimedOut`) when nothing comes, or no time-out can be kept.
    pub const fn new(stream: S, options: Options) -> Self {
        Self { exchange: Exchange::new(stream, options) }
    }

    /// The stream.
    pub const fn stream(&self) -> &S {
        self.exchange.stream()
    }

    /// How patient the client is.
    pub const fn options(&self) -> Options {
        self.exchange.options()
    }

    /// Makes the client more or less patient.
    pub const fn set_options(&mut self, options: Options) {
        self.exchange.set_options(options);
    }

    /// Frames of the board that came damaged so far.
    pub const fn dropped(&self) -> u64 {
        self.exchange.dropped()
    }

    /// What the board said about itself unasked since the last call: it has (re)started.
    pub fn restarted(&mut self) -> Option<Board> {
        match postcard::from_bytes(&self.exchange.take_unasked()?) {
            Ok(Reply::Report(report)) => Some(report.into()),
            _ => None,
        }
    }

    /// Tells the board whom it flies for; its neighbour table starts empty.
    ///
    /// # Errors
    /// See [`PilError`]; [`RequestError::Actor`] when the board has no sound actor.
    pub fn hello(&mut self, setup: Setup) -> Result<Board, PilError> {
        self.ask(&Request::Hello(setup), board)
    }

    /// Runs the self-test again.
    ///
    /// # Errors
    /// As [`Self::hello`].
    pub fn self_test(&mut self) -> Result<Board, PilError> {
        self.ask(&Request::SelfTest, board)
    }

    /// Passes on a neighbour's message heard at `now` at `own_position` (ticks).
    ///
    /// # Errors
    /// See [`PilError`].
    pub fn hear(&mut self, now: Moment, own_position: Vec2, message: &Message) -> Result<Heard, PilError> {
        self.hear_bytes(now, own_position, message.encode(&mut [0; MAX_LEN]))
    }

    /// Passes on what may be a neighbour's message.
    ///
    /// # Errors
    /// See [`PilError`]; [`RequestError::Message`] when it is none.
    pub fn hear_bytes(&mut self, now: Moment, own_position: Vec2, message: &[u8]) -> Result<Heard, PilError> {
        if message.len() > MAX_LEN {
            return Err(PilError::Refused(RequestError::Message));
        }
        let position = [own_position.x, own_position.y];
        self.ask(&Request::Hear(Hear { now, position, message }), heard)
    }

    /// Lets the board observe and encode the step `now` from its own state and the PoIs
    /// (positions, ticks; those out of view are left out).
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

    /// Lets the board decide the step that it observed last.
    ///
    /// # Errors
    /// See [`PilError`]; [`RequestError::NotObserved`] when that was another step.
    pub fn decide(&mut self, step: u32) -> Result<Decided, PilError> {
        self.ask(&Request::Decide { step }, |reply| decided(step, reply))
    }

    /// How the board and the line are.
    ///
    /// # Errors
    /// See [`PilError`].
    pub fn status(&mut self) -> Result<Status, PilError> {
        self.ask(&Request::Status, |reply| match reply {
            Reply::Status(status) => Some(Ok(status)),
            _ => None,
        })
    }

    /// The signature of the board's actor over its first `cases` neighbourhoods (see
    /// [`firmware_core::actor::fingerprint`]), asked for `chunk` cases at a time so that a slow
    /// board answers within the time-out. `progress` hears how many are done.
    ///
    /// # Errors
    /// See [`PilError`]; [`PilError::LostCount`] when the board restarted on the way.
    pub fn signature(&mut self, cases: u32, chunk: u16, mut progress: impl FnMut(u32)) -> Result<u64, PilError> {
        let chunk = chunk.clamp(1, MAX_CASES);
        let mut from = 0;
        loop {
            let add = (cases - from).min(u32::from(chunk)) as u16;
            let request = Request::Sign { from, cases: add };
            let (done, value) = self.ask(&request, |reply| match reply {
                Reply::Signature { cases, value } => Some(Ok((cases, value))),
                _ => None,
            })?;
            // A second attempt after a lost answer finds the cases added: the same count.
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

    /// Asks, and makes of the answer what `pick` does.
    fn ask<T>(
        &mut self,
        request: &Request<'_>,
        pick: impl FnOnce(Reply<'_>) -> Option<Result<T, PilError>>,
    ) -> Result<T, PilError> {
        let record = self.exchange.ask(request)?;
        read(&record, name(request), pick)
    }
}
