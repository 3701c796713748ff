//! Writing a tlog beside a flight, which it must never hold up.

use super::{SETUP_SIGNING, TIME};
use crate::frame::{Frame, MAX_LEN};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

/// Records are handed over when they are this many bytes,
const BATCH: usize = 16 * 1024;
/// or when the oldest of them is this old, microseconds of recorded time.
const BATCH_US: u64 = 1_000_000;
/// Batches that may wait for a slow disk: 4 MiB.
const WAITING: usize = 256;

/// A recorder. A thread of its own writes, so that a slow disk delays nobody; when the disk is
/// full or too slow, records are lost, counted and said once, and the flight goes on.
#[derive(Debug)]
pub struct TlogWriter {
    batch: Vec<u8>,
    records: u64,
    since_us: u64,
    queue: Option<SyncSender<Batch>>,
    thread: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Batch {
    bytes: Vec<u8>,
    records: u64,
}

#[derive(Debug, Default)]
struct Shared {
    lost: AtomicU64,
    error: Mutex<Option<io::Error>>,
}

impl TlogWriter {
    /// Creates the file, or empties it.
    ///
    /// # Errors
    /// The file cannot be created, or the thread cannot be started.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::to(File::create(path)?)
    }

    /// Records into anything.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn to<W: Write + Send + 'static>(output: W) -> io::Result<Self> {
        let (queue, batches) = sync_channel::<Batch>(WAITING);
        let shared = Arc::new(Shared::default());
        let ours = Arc::clone(&shared);
        let job = move || {
            let mut output = Output { output, rest: Vec::new() };
            for batch in batches {
                if let Err(error) = output.write(&batch.bytes) {
                    ours.lose(batch.records, error);
                }
            }
            if let Err(error) = output.output.flush() {
                ours.lose(0, error);
            }
        };
        let thread = thread::Builder::new().name("tlog".into()).spawn(job)?;
        let (queue, thread) = (Some(queue), Some(thread));
        Ok(Self { batch: Vec::with_capacity(BATCH), records: 0, since_us: 0, queue, thread, shared })
    }

    /// Records a frame that was sent or received at this time, microseconds since 1970.
    ///
    /// What was recorded is on the disk about a second of recorded time later, or when this is
    /// dropped.
    pub fn record(&mut self, unix_us: u64, frame: &Frame) {
        if frame.message_id() == SETUP_SIGNING {
            return;
        }
        if self.batch.is_empty() {
            self.since_us = unix_us;
        }
        self.batch.extend_from_slice(&unix_us.to_be_bytes());
        self.batch.extend_from_slice(frame.bytes());
        self.records += 1;
        // Also when the time has jumped back.
        let old = unix_us.abs_diff(self.since_us) >= BATCH_US;
        if old || self.batch.len() + TIME + MAX_LEN > BATCH {
            self.flush();
        }
    }

    /// Hands what was recorded to the disk, without waiting for it.
    pub fn flush(&mut self) {
        if self.batch.is_empty() {
            return;
        }
        let bytes = std::mem::replace(&mut self.batch, Vec::with_capacity(BATCH));
        let batch = Batch { bytes, records: std::mem::take(&mut self.records) };
        match self.queue.as_ref().map(|queue| queue.try_send(batch)) {
            Some(Err(TrySendError::Full(batch))) => {
                self.shared.lose(batch.records, io::Error::other("the disk is too slow"));
            }
            Some(Err(TrySendError::Disconnected(batch))) => {
                self.shared.lose(batch.records, io::Error::other("the recorder has ended"));
            }
            Some(Ok(())) | None => {}
        }
    }

    /// Records that were lost.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
    }

    /// Why records were lost since this was asked last; `None` when none were. Say it once: a
    /// full disk fails again every second.
    #[must_use]
    pub fn take_error(&self) -> Option<io::Error> {
        self.shared.error.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Waits until everything is written.
impl Drop for TlogWriter {
    fn drop(&mut self) {
        self.flush();
        // Without a queue the thread ends.
        self.queue = None;
        if let Some(Err(_)) = self.thread.take().map(JoinHandle::join) {
            self.shared.lose(0, io::Error::other("the recorder has ended"));
        }
    }
}

impl Shared {
    fn lose(&self, records: u64, error: io::Error) {
        self.lost.fetch_add(records, Ordering::Relaxed);
        *self.error.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
    }
}

/// A file that may be full at times.
struct Output<W> {
    output: W,
    /// The end of a batch that was written in part. It goes first, or the rest would be garbage.
    rest: Vec<u8>,
}

impl<W: Write> Output<W> {
    /// Writes a batch, or nothing of it; or takes the part of it that is not written along.
    fn write(&mut self, batch: &[u8]) -> io::Result<()> {
        let rest = std::mem::take(&mut self.rest);
        let (written, result) = write_some(&mut self.output, &rest);
        if result.is_err() {
            self.rest = rest[written..].to_vec();
            return result;
        }
        let (written, result) = write_some(&mut self.output, batch);
        if result.is_err() && written > 0 {
            self.rest = batch[written..].to_vec();
            return Ok(());
        }
        result
    }
}

/// Like `write_all`, but says how much was written.
fn write_some(output: &mut impl Write, bytes: &[u8]) -> (usize, io::Result<()>) {
    let mut written = 0;
    while written < bytes.len() {
        match output.write(&bytes[written..]) {
            Ok(0) => return (written, Err(io::ErrorKind::WriteZero.into())),
            Ok(len) => written += len,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return (written, Err(error)),
        }
    }
    (written, Ok(()))
}
