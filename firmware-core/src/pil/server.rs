//! The board's end of the line.

use super::error::RequestError;
use super::frame::{CHECKSUM, Deframer, FrameError, decode_frame, encode_frame, frame_len};
use super::limits::{MAX_REPLY, MAX_REQUEST, UNASKED, VERSION};
use super::node::Node;
use super::reply::Reply;
use super::request::Request;
use super::status::{Counters, Status};

/// The board's end of the line: takes bytes from the line one at a time and has the
/// answer ready when a request is complete.
///
/// It owns all it needs, about 4 KiB, and starts in a constant, so it can be a static:
///
/// ```
/// # use firmware_core::pil::Server;
/// # let (file, line, mut sent) = (&[0u8; 4][..], [1u8, 2, 0], Vec::new());
/// let mut server = Server::new();
/// sent.extend_from_slice(server.boot(file));
/// for byte in line {
///     if let Some(answer) = server.push(byte) {
///         sent.extend_from_slice(answer);
///     }
/// }
/// ```
pub struct Server<'a> {
    node: Node<'a>,
    deframer: Deframer<{ MAX_REQUEST + CHECKSUM }>,
    counters: Counters,
    reply: [u8; frame_len(MAX_REPLY)],
}

impl Default for Server<'_> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'a> Server<'a> {
    /// Without an actor; see [`Self::boot`].
    #[must_use]
    pub const fn new() -> Self {
        Self {
            node: Node::new(),
            deframer: Deframer::new(),
            counters: Counters { done: 0, refused: 0, too_long: 0, broken: 0, too_short: 0, checksum: 0, version: 0 },
            reply: [0; frame_len(MAX_REPLY)],
        }
    }

    /// Loads the actor, runs its self-test and returns the report to send. Without a sound
    /// actor the server still answers, but flies nothing.
    pub fn boot(&mut self, file: &'a [u8]) -> &[u8] {
        self.node.load(file);
        encode_frame(UNASKED, &Reply::Report(self.node.report()), &mut self.reply).unwrap_or_default()
    }

    /// Whether there is an actor that passed its self-test.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.node.report().actor.is_ok()
    }

    /// What came over the line so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Takes the next byte from the line; returns the answer to send when it completes a
    /// request. Frames that are no requests are counted and get no answer.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        let content = match self.deframer.push(byte)? {
            Ok(content) => content,
            Err(e) => {
                self.counters.count(e);
                return None;
            }
        };
        let (tag, reply) = match decode_frame(content) {
            Ok((tag, record)) => (tag, carry_out(&mut self.node, &self.counters, record)),
            Err(e) => {
                self.counters.count(e);
                match (e, content) {
                    (FrameError::Version(_), &[_, tag, ..]) => (tag, Err(RequestError::Version(VERSION))),
                    _ => return None,
                }
            }
        };
        let counter = if reply.is_ok() { &mut self.counters.done } else { &mut self.counters.refused };
        *counter = counter.wrapping_add(1);
        encode_frame(tag, &reply.unwrap_or_else(Reply::Refused), &mut self.reply)
    }
}

fn carry_out<'n>(node: &'n mut Node<'_>, counters: &Counters, record: &[u8]) -> Result<Reply<'n>, RequestError> {
    match postcard::take_from_bytes(record) {
        Ok((request, [])) => match request {
            Request::Hello(setup) => {
                node.hello(setup);
                Ok(Reply::Report(node.report()))
            }
            Request::Hear(heard) => node.hear(&heard),
            Request::Observe(request) => node.observe(&request),
            Request::Decide { step } => node.decide(step),
            Request::Status => Ok(Reply::Status(Status { counters: *counters, ..node.status() })),
            Request::SelfTest => {
                node.self_test();
                Ok(Reply::Report(node.report()))
            }
            Request::Sign { from, cases } => node.sign(from, cases),
        },
        _ => Err(RequestError::Unreadable),
    }
}
