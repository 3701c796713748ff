//! Requests and answers as frames on a stream, with time-outs and repetition.

use crate::error::PilError;
use firmware_core::pil::{
    Deframer, FrameError, MAX_REPLY, MAX_REQUEST, Request, UNASKED, decode_frame, encode_frame, frame_len,
};
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

/// Time-out and attempts of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How long to wait for an answer. Zero waits only until the stream has nothing more to read.
    pub timeout: Duration,
    /// How often a request is sent before it fails, at least once.
    pub attempts: u32,
}

impl Default for Options {
    /// Three attempts of half a second each.
    fn default() -> Self {
        Self { timeout: Duration::from_millis(500), attempts: 3 }
    }
}

/// Version, tag, record and checksum.
const CONTENT: usize = MAX_REPLY + 4;

/// Most requests that wait for their answers at once. They and their answers fit into the buffers of a socket, so that
/// neither end blocks until the other reads; and they are fewer than there are tags.
const WINDOW: usize = 32;

/// A request's name in errors.
pub(crate) const fn name(request: &Request<'_>) -> &'static str {
    match request {
        Request::Hello(_) => "hello",
        Request::Hear(_) => "hear",
        Request::Observe(_) => "observe",
        Request::Decide { .. } => "decide",
        Request::Status => "status",
        Request::SelfTest => "self-test",
        Request::Sign { .. } => "fingerprint",
    }
}

/// A stream with frames in it.
#[derive(Debug)]
pub(crate) struct Exchange<S> {
    stream: S,
    options: Options,
    deframer: Deframer<CONTENT>,
    /// Bytes read but not decoded yet.
    pending: VecDeque<u8>,
    tag: u8,
    /// The last record that the board sent by itself.
    unasked: Option<Vec<u8>>,
    dropped: u64,
}

/// An intact frame.
struct Frame {
    tag: u8,
    record: Vec<u8>,
}

impl<S: Read + Write> Exchange<S> {
    pub(crate) const fn new(stream: S, options: Options) -> Self {
        Self {
            stream,
            options,
            deframer: Deframer::new(),
            pending: VecDeque::new(),
            tag: UNASKED,
            unasked: None,
            dropped: 0,
        }
    }

    pub(crate) const fn stream(&self) -> &S {
        &self.stream
    }

    pub(crate) const fn set_options(&mut self, options: Options) {
        self.options = options;
    }

    pub(crate) const fn options(&self) -> Options {
        self.options
    }

    /// Number of frames of the board that arrived corrupted.
    pub(crate) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The last record that came unasked, once.
    pub(crate) const fn take_unasked(&mut self) -> Option<Vec<u8>> {
        self.unasked.take()
    }

    /// Sends a request until it is answered; returns the answer's record.
    pub(crate) fn ask(&mut self, request: &Request<'_>) -> Result<Vec<u8>, PilError> {
        Ok(self.ask_all(std::slice::from_ref(request))?.swap_remove(0))
    }

    /// Sends all requests without waiting in between, until each is answered; returns the answers' records. More than
    /// one request needs a line with flow control; see [`WINDOW`].
    pub(crate) fn ask_all(&mut self, requests: &[Request<'_>]) -> Result<Vec<Vec<u8>>, PilError> {
        let mut records = Vec::with_capacity(requests.len());
        for window in requests.chunks(WINDOW) {
            records.append(&mut self.ask_window(window)?);
        }
        Ok(records)
    }

    /// Sends a window of requests at once. Where an answer is lost, the window is split in two, since on a bad line a
    /// long one would hardly ever succeed as a whole.
    fn ask_window(&mut self, requests: &[Request<'_>]) -> Result<Vec<Vec<u8>>, PilError> {
        let alone = requests.len() <= 1;
        let attempts = if alone { self.options.attempts.max(1) } else { 1 };
        for _ in 0..attempts {
            let records = self.attempt(requests)?;
            if records.len() == requests.len() {
                return Ok(records);
            }
        }
        if alone {
            return Err(PilError::Silent { request: requests.first().map_or("", name), attempts });
        }
        let (first, second) = requests.split_at(requests.len() / 2);
        let mut records = self.ask_window(first)?;
        records.append(&mut self.ask_window(second)?);
        Ok(records)
    }

    /// Sends the requests once; returns the records up to the first that is missing.
    fn attempt(&mut self, requests: &[Request<'_>]) -> Result<Vec<Vec<u8>>, PilError> {
        let tags = self.send(requests)?;
        let mut records = Vec::with_capacity(requests.len());
        let timeout = self.options.timeout;
        let deadline = (!timeout.is_zero()).then(|| Instant::now() + timeout);
        // Answers to earlier attempts may still arrive; they are ignored.
        while records.len() < requests.len() {
            let Some(frame) = self.receive(deadline)? else { break };
            // The board answers in order: after a lost answer no later one counts.
            if tags.get(records.len()) == Some(&frame.tag) {
                records.push(frame.record);
            } else if frame.tag == UNASKED {
                self.unasked = Some(frame.record);
            }
        }
        Ok(records)
    }

    /// Writes these requests in one go and returns their tags.
    fn send(&mut self, requests: &[Request<'_>]) -> Result<Vec<u8>, PilError> {
        let (mut bytes, mut tags) = (Vec::new(), Vec::with_capacity(requests.len()));
        for request in requests {
            self.tag = if self.tag == u8::MAX { UNASKED + 1 } else { self.tag + 1 };
            tags.push(self.tag);
            let mut buffer = [0; frame_len(MAX_REQUEST)];
            bytes.extend_from_slice(
                encode_frame(self.tag, request, &mut buffer).ok_or(Error::from(ErrorKind::InvalidInput))?,
            );
        }
        self.stream.write_all(&bytes)?;
        self.stream.flush()?;
        Ok(tags)
    }

    /// The next intact frame, or nothing until the deadline (none: until nothing comes).
    fn receive(&mut self, deadline: Option<Instant>) -> Result<Option<Frame>, PilError> {
        loop {
            while let Some(byte) = self.pending.pop_front() {
                let content = match self.deframer.push(byte) {
                    Some(Ok(content)) => content,
                    Some(Err(_)) => {
                        self.dropped += 1;
                        continue;
                    }
                    None => continue,
                };
                match decode_frame(content) {
                    Ok((tag, record)) => return Ok(Some(Frame { tag, record: record.to_vec() })),
                    Err(FrameError::Version(version)) => return Err(PilError::Version(version)),
                    Err(_) => self.dropped += 1,
                }
            }
            // A line that never falls silent does not outlast the deadline either.
            let more = self.fill()?;
            if deadline.map_or(!more, |d| Instant::now() >= d) {
                return Ok(None);
            }
        }
    }

    /// Reads what there is; false when there is nothing yet.
    fn fill(&mut self) -> Result<bool, PilError> {
        let mut chunk = [0; 256];
        match self.stream.read(&mut chunk) {
            Ok(0) => Err(PilError::Closed),
            Ok(n) => {
                self.pending.extend(&chunk[..n]);
                Ok(true)
            }
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                Ok(false)
            }
            Err(e) => Err(e.into()),
        }
    }
}
