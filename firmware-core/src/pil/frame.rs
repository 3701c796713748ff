//! Frames: a zero, then version, tag, record and CRC-32 without any zero in them (COBS), then a zero.

use super::limits::VERSION;
use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use postcard::ser_flavors::Flavor;
use serde::Serialize;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of the checksum at the end of a frame.
pub(super) const CHECKSUM: usize = 4;

/// Greatest length on the line of a frame with `n` bytes of version, tag and record.
#[must_use]
pub const fn frame_len(n: usize) -> usize {
    // Two zeros, and one code byte for every 254 bytes begun.
    2 + n + CHECKSUM + (n + CHECKSUM) / 254 + 1
}

/// Writes a frame with this record into `out` and returns the part it takes; `None` when
/// it does not fit.
pub fn encode_frame<'b, T: Serialize>(tag: u8, record: &T, out: &'b mut [u8]) -> Option<&'b [u8]> {
    let mut encoder = Encoder { out, at: 0, code_at: 0, sum: CRC.digest() };
    encoder.put(0)?;
    encoder.open_block()?;
    encoder.checked(VERSION)?;
    encoder.checked(tag)?;
    postcard::serialize_with_flavor(record, encoder).ok()
}

/// Splits the content of a frame, as a [`Deframer`] finds it, into tag and record.
///
/// # Errors
/// [`FrameError::TooShort`] or [`FrameError::Version`].
pub fn decode_frame(content: &[u8]) -> Result<(u8, &[u8]), FrameError> {
    match *content {
        [VERSION, tag, ref record @ ..] => Ok((tag, record)),
        [version, _, ..] => Err(FrameError::Version(version)),
        _ => Err(FrameError::TooShort),
    }
}

/// Writes COBS and adds up the checksum while a record is serialised.
struct Encoder<'b> {
    out: &'b mut [u8],
    at: usize,
    /// Where the code of the present block goes.
    code_at: usize,
    sum: Digest<'static, u32>,
}

impl<'b> Encoder<'b> {
    fn put(&mut self, byte: u8) -> Option<()> {
        *self.out.get_mut(self.at)? = byte;
        self.at += 1;
        Some(())
    }

    fn open_block(&mut self) -> Option<()> {
        self.code_at = self.at;
        self.put(0)
    }

    fn close_block(&mut self) -> Option<()> {
        *self.out.get_mut(self.code_at)? = (self.at - self.code_at) as u8;
        Some(())
    }

    /// A byte of the content.
    fn stuff(&mut self, byte: u8) -> Option<()> {
        if self.at - self.code_at == 255 {
            self.close_block()?;
            self.open_block()?;
        }
        if byte != 0 {
            return self.put(byte);
        }
        self.close_block()?;
        self.open_block()
    }

    /// A byte of the content that the checksum covers.
    fn checked(&mut self, byte: u8) -> Option<()> {
        self.sum.update(&[byte]);
        self.stuff(byte)
    }

    fn finish(mut self) -> Option<&'b [u8]> {
        let sum = self.sum.clone().finalize();
        for byte in sum.to_le_bytes() {
            self.stuff(byte)?;
        }
        self.close_block()?;
        self.put(0)?;
        self.out.get(..self.at)
    }
}

impl<'b> Flavor for Encoder<'b> {
    type Output = &'b [u8];

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.checked(byte).ok_or(postcard::Error::SerializeBufferFull)
    }

    fn finalize(self) -> postcard::Result<&'b [u8]> {
        self.finish().ok_or(postcard::Error::SerializeBufferFull)
    }
}

/// Why a frame is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum FrameError {
    /// Longer than any valid frame.
    #[error("a frame longer than any valid one")]
    TooLong,
    /// It ends before its COBS blocks do.
    #[error("a frame that ends in the middle of a block")]
    Broken,
    /// Too short for version, tag and checksum.
    #[error("a frame too short for a header and a checksum")]
    TooShort,
    /// The checksum does not fit.
    #[error("a frame with a wrong checksum")]
    Checksum,
    /// Another version of the protocol.
    #[error("protocol version {0}, this side speaks {VERSION}: update the older of the two")]
    Version(u8),
}

/// Finds frames in a stream of bytes. `N` is the greatest length of version, tag, record
/// and checksum.
#[derive(Clone, Debug)]
pub struct Deframer<const N: usize> {
    buffer: [u8; N],
    len: usize,
    /// Bytes to come in the present block.
    left: u8,
    /// Whether the present block ends with a zero (unless the frame does).
    zero_due: bool,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Nothing since the last zero.
    Empty,
    Inside,
    /// No room: the rest is skipped.
    Overrun,
}

impl<const N: usize> Default for Deframer<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Deframer<N> {
    /// Waits for a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: [0; N], len: 0, left: 0, zero_due: false, state: State::Empty }
    }

    /// Takes the next byte. At the end of a frame: its content (version, tag and record),
    /// or why it is dropped. Zeros between frames say nothing.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if byte == 0 {
            return self.end();
        }
        match self.state {
            State::Overrun => return None,
            State::Empty => (self.len, self.left, self.zero_due, self.state) = (0, 0, false, State::Inside),
            State::Inside => {}
        }
        if self.left > 0 {
            self.left -= 1;
            self.store(byte);
        } else {
            if self.zero_due {
                self.store(0);
            }
            self.left = byte - 1;
            self.zero_due = byte != 255;
        }
        None
    }

    fn store(&mut self, byte: u8) {
        match self.buffer.get_mut(self.len) {
            Some(place) => {
                *place = byte;
                self.len += 1;
            }
            None => self.state = State::Overrun,
        }
    }

    fn end(&mut self) -> Option<Result<&[u8], FrameError>> {
        match core::mem::replace(&mut self.state, State::Empty) {
            State::Empty => return None,
            State::Overrun => return Some(Err(FrameError::TooLong)),
            State::Inside if self.left > 0 => return Some(Err(FrameError::Broken)),
            State::Inside => {}
        }
        let stored = self.buffer.get(..self.len).unwrap_or_default();
        let Some((content, sum)) = stored.split_last_chunk::<CHECKSUM>() else {
            return Some(Err(FrameError::TooShort));
        };
        let intact = CRC.checksum(content) == u32::from_le_bytes(*sum);
        Some(if intact { Ok(content) } else { Err(FrameError::Checksum) })
    }
}
