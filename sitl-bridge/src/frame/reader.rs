//! Parsing frames from received bytes.
//!
//! Bytes are only consumed as a frame when their checksum is right. After any other candidate the parser
//! advances by one byte, so a flipped length or a magic byte inside garbage never costs the valid
//! frame behind it.

use super::checksum::{checksum, crc_extra};
use super::layout::{
    CHECKSUM, FLAG_SIGNED, Frame, HEADER_V1, HEADER_V2, MAGIC_V1, MAGIC_V2, MAX_LEN, SIGNATURE, message_id,
};
use super::rejected::{Counts, Rejected};

/// Whether a link carries datagrams or a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Datagrams: no frame continues in the next one.
    Datagrams,
    /// A stream (TCP, serial): received pieces end anywhere in a frame.
    Stream,
}

/// Parses the frames that one link receives.
///
/// Push the received bytes, then call [`Reader::next_frame`] until it returns `None`. On datagram links
/// one reader serves all senders. In a stream, a damaged length can hold back the frames behind it
/// until as many bytes have arrived, 280 at most.
#[derive(Clone, Debug)]
pub struct Reader {
    source: Source,
    buffer: Vec<u8>,
    /// Number of bytes of `buffer` that are parsed.
    at: usize,
    /// Number of bytes of `buffer` that are already counted as rejected.
    counted: usize,
    counts: Counts,
}

/// Why there is no frame at a byte.
pub(crate) enum NoFrame {
    /// There may be one once more bytes have arrived.
    Short,
    /// There is none; the candidate would have had this length.
    Not(Rejected, usize),
}

impl Reader {
    /// A reader that has received nothing.
    #[must_use]
    pub const fn new(source: Source) -> Self {
        Self { source, buffer: Vec::new(), at: 0, counted: 0, counts: Counts::new() }
    }

    /// Adds a datagram, or the next piece of the stream.
    ///
    /// On a datagram link this drops the rest of the last datagram.
    pub fn push(&mut self, bytes: &[u8]) {
        match self.source {
            Source::Datagrams => self.buffer.clear(),
            Source::Stream => drop(self.buffer.drain(..self.at)),
        }
        self.counted = match self.source {
            Source::Datagrams => 0,
            Source::Stream => self.counted.saturating_sub(self.at),
        };
        self.at = 0;
        self.buffer.extend_from_slice(bytes);
    }

    /// Drops an incomplete frame, when a stream was cut off and is connected again.
    pub fn reset(&mut self) {
        self.buffer.clear();
        (self.at, self.counted) = (0, 0);
    }

    /// The next frame, in the order of arrival: one whose checksum holds, or one of an unknown
    /// message, which only a signature can authenticate (see [`Frame::is_checked`]).
    pub fn next_frame(&mut self) -> Option<Frame> {
        while self.at < self.buffer.len() {
            let rest = &self.buffer[self.at..];
            let garbage = rest.iter().position(|b| matches!(b, &MAGIC_V1 | &MAGIC_V2)).unwrap_or(rest.len());
            if garbage > 0 {
                self.reject(Rejected::Garbage, garbage);
                self.at += garbage;
                continue;
            }
            match parse(rest) {
                Ok(frame) if frame.checked => {
                    self.at += frame.len;
                    self.counted = self.at;
                    return Some(frame);
                }
                Ok(frame) => match hidden(rest, frame.len, self.source) {
                    Hidden::None => {
                        self.at += frame.len;
                        self.counted = self.at;
                        return Some(frame);
                    }
                    Hidden::Perhaps => return None,
                    Hidden::Frame(at) => {
                        self.reject(Rejected::Garbage, at);
                        self.at += at;
                    }
                },
                Err(NoFrame::Short) if self.source == Source::Stream => return None,
                Err(NoFrame::Short) => {
                    self.reject(Rejected::Truncated, rest.len());
                    self.at += 1;
                }
                Err(NoFrame::Not(reason, len)) => {
                    self.reject(reason, len);
                    self.at += 1;
                }
            }
        }
        None
    }

    /// Bytes and candidates that were no frame, by reason.
    #[must_use]
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Counts the next `len` bytes as one case of `reason`, unless the first of them is counted already.
    fn reject(&mut self, reason: Rejected, len: usize) {
        let end = self.at + len;
        let fresh = match reason {
            // A run of garbage may go on behind what was counted before.
            Rejected::Garbage => end > self.counted,
            _ => self.at >= self.counted,
        };
        if fresh {
            self.counts.count(reason);
            self.counted = end;
        }
    }
}

/// A search for frames inside a candidate whose checksum cannot be verified.
enum Hidden {
    /// No valid frame.
    None,
    /// Perhaps one, once more bytes have arrived.
    Perhaps,
    /// A valid frame at this offset: the candidate was none.
    Frame(usize),
}

fn hidden(bytes: &[u8], len: usize, source: Source) -> Hidden {
    for at in 1..len {
        match parse(&bytes[at..]) {
            Ok(frame) if frame.checked => return Hidden::Frame(at),
            Err(NoFrame::Short) if source == Source::Stream => return Hidden::Perhaps,
            _ => {}
        }
    }
    Hidden::None
}

/// The frame at the beginning of `bytes`.
pub(crate) fn parse(bytes: &[u8]) -> Result<Frame, NoFrame> {
    let (header, signature) = match *bytes {
        [MAGIC_V1, ..] => (HEADER_V1, 0),
        [MAGIC_V2, _, flags, ..] if flags & !FLAG_SIGNED != 0 => {
            return Err(NoFrame::Not(Rejected::UnknownFlags, HEADER_V2));
        }
        [MAGIC_V2, _, FLAG_SIGNED, ..] => (HEADER_V2, SIGNATURE),
        [MAGIC_V2, ..] => (HEADER_V2, 0),
        [] => return Err(NoFrame::Short),
        _ => return Err(NoFrame::Not(Rejected::Garbage, 1)),
    };
    let payload = usize::from(*bytes.get(1).ok_or(NoFrame::Short)?);
    let end = header + payload;
    let len = end + CHECKSUM + signature;
    let whole = bytes.get(..len).ok_or(NoFrame::Short)?;
    let extra = crc_extra(message_id(whole));
    if let Some(extra) = extra {
        let sum = u16::from_le_bytes([whole[end], whole[end + 1]]);
        if checksum(&whole[1..end], extra) != sum {
            return Err(NoFrame::Not(Rejected::BadChecksum, len));
        }
    }
    let mut frame = Frame { bytes: [0; MAX_LEN], len, checked: extra.is_some() };
    frame.bytes[..len].copy_from_slice(whole);
    Ok(frame)
}
