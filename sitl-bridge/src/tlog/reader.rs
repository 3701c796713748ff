//! Reading a tlog, even a damaged one.

use super::layout::TIME;
use crate::frame::{self, Frame, MAX_LEN, NoFrame};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes read at once.
const CHUNK: usize = 64 * 1024;

/// One recorded frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// When it was sent or received, microseconds since 1970.
    pub unix_us: u64,
    /// The frame.
    pub frame: Frame,
}

/// The records of a tlog, in order. Bytes that are no record are skipped and counted.
#[derive(Debug)]
pub struct TlogReader<R> {
    input: R,
    buffer: Vec<u8>,
    /// Bytes of `buffer` done with.
    at: usize,
    ended: bool,
    skipped: u64,
    cut: bool,
}

impl Record {
    /// What it takes in the tlog, bytes.
    fn len(&self) -> usize {
        TIME + self.frame.bytes().len()
    }
}

impl TlogReader<File> {
    /// Opens a file.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        File::open(path).map(Self::new)
    }
}

impl<R: Read> TlogReader<R> {
    /// Reads from anything.
    pub const fn new(input: R) -> Self {
        Self { input, buffer: Vec::new(), at: 0, ended: false, skipped: 0, cut: false }
    }

    /// Bytes met so far that belong to no record.
    #[must_use]
    pub const fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Whether the tlog ends in the middle of a record, as after a power cut. Known once the
    /// last record was taken.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        self.cut
    }

    fn next_record(&mut self) -> io::Result<Option<Record>> {
        loop {
            // Room for two records: an unchecked one must be followed by another.
            while self.buffer.len() - self.at < 2 * (TIME + MAX_LEN) && !self.ended {
                self.fill()?;
            }
            let rest = &self.buffer[self.at..];
            match record(rest) {
                Ok(record) if record.frame.is_checked() || stands(rest, record.len()) => {
                    self.at += record.len();
                    return Ok(Some(record));
                }
                Err(NoFrame::Short) if hidden(rest, rest.len()).is_none() => {
                    self.cut = !rest.is_empty();
                    self.at = self.buffer.len();
                    return Ok(None);
                }
                _ => {
                    self.skipped += 1;
                    self.at += 1;
                }
            }
        }
    }

    fn fill(&mut self) -> io::Result<()> {
        self.buffer.drain(..self.at);
        self.at = 0;
        let len = self.buffer.len();
        self.buffer.resize(len + CHUNK, 0);
        let read = loop {
            match self.input.read(&mut self.buffer[len..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read,
            }
        };
        self.buffer.truncate(len + read.as_ref().map_or(0, |&n| n));
        self.ended = read? == 0;
        Ok(())
    }
}

impl<R: Read> Iterator for TlogReader<R> {
    type Item = io::Result<Record>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_record().transpose()
    }
}

/// The record at the beginning of `bytes`. It is [`NoFrame::Short`] only near the end of the
/// tlog: more bytes than that are always there.
fn record(bytes: &[u8]) -> Result<Record, NoFrame> {
    let (time, rest) = bytes.split_first_chunk::<TIME>().ok_or(NoFrame::Short)?;
    frame::parse(rest).map(|frame| Record { unix_us: u64::from_be_bytes(*time), frame })
}

/// Whether `len` bytes that look like a record with an unknown message are one: nothing sound
/// begins inside, and the end or another record follows.
fn stands(bytes: &[u8], len: usize) -> bool {
    let goes_on = !matches!(record(&bytes[len..]), Err(NoFrame::Not(..)));
    goes_on && hidden(bytes, len).is_none()
}

/// The first sound record that begins within `len` bytes, but not at their beginning.
fn hidden(bytes: &[u8], len: usize) -> Option<usize> {
    (1..len).find(|&at| record(&bytes[at..]).is_ok_and(|record| record.frame.is_checked()))
}
