//! Reading a tlog, even a damaged one.

use super::TIME;
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
                Ok(record) => {
                    self.at += TIME + record.frame.bytes().len();
                    return Ok(Some(record));
                }
                Err(NoRecord::Cut) => {
                    // No whole record may hide in what looks like the beginning of one.
                    let whole = |at: &usize| record(&rest[*at..]).is_ok_and(|r| r.frame.is_checked());
                    let Some(at) = (1..rest.len()).find(whole) else {
                        self.cut = !rest.is_empty();
                        self.at = self.buffer.len();
                        return Ok(None);
                    };
                    self.skipped += at as u64;
                    self.at += at;
                }
                Err(NoRecord::Garbage) => {
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

/// Why no record begins here.
enum NoRecord {
    /// All there is may be the beginning of one.
    Cut,
    Garbage,
}

fn record(bytes: &[u8]) -> Result<Record, NoRecord> {
    let (time, rest) = bytes.split_first_chunk::<TIME>().ok_or(NoRecord::Cut)?;
    match frame::parse(rest) {
        Ok(frame) if frame.is_checked() || goes_on(&rest[frame.bytes().len()..]) => {
            Ok(Record { unix_us: u64::from_be_bytes(*time), frame })
        }
        Err(NoFrame::Short) => Err(NoRecord::Cut),
        _ => Err(NoRecord::Garbage),
    }
}

/// Whether this can be what follows a record: nothing, or another one.
fn goes_on(bytes: &[u8]) -> bool {
    match bytes.split_first_chunk::<TIME>() {
        None => bytes.is_empty(),
        Some((_, rest)) => !matches!(frame::parse(rest), Err(NoFrame::Not(..))),
    }
}
