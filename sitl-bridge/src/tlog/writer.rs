//! Writing a tlog beside a flight, which it must never hold up.

use super::disk::{Output, RecordingFile};
use super::layout::{SETUP_SIGNING, TIME};
use super::note::{NOTE_COMPONENT, Note};
use crate::frame::{Encoder, Frame, MAX_LEN};
use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Records go to the disk together when they are this many bytes,
const BATCH: usize = 16 * 1024;
/// and else after this time by the host's clock. With the disk's own time a power cut costs less than a second.
const EVERY: Duration = Duration::from_millis(500);
/// Batches that may wait for a slow disk: 4 MiB.
const WAITING: usize = 256;

/// A recorder. A thread of its own writes, so that a slow disk delays nobody; when the disk is
/// full or too slow, records are lost, counted and said once, and the flight goes on.
#[derive(Debug)]
pub struct TlogWriter {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    /// Notes so far.
    notes: u16,
}

#[derive(Debug, Default)]
struct Batch {
    bytes: Vec<u8>,
    records: u64,
}

/// What waits for the disk.
#[derive(Debug, Default)]
struct Queue {
    full: VecDeque<Batch>,
    open: Batch,
    /// Everything is to be written now.
    hurry: bool,
    closed: bool,
}

#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    wake: Condvar,
    lost: AtomicU64,
    error: Mutex<Option<io::Error>>,
}

impl TlogWriter {
    /// Creates the file. One that is there is never written over: it is evidence. (A pipe or a device may be there.)
    ///
    /// # Errors
    /// The file exists ([`io::ErrorKind::AlreadyExists`]) or cannot be created, or the thread cannot be started.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::to(RecordingFile::create(path)?)
    }

    /// Records into anything. It is flushed after each piece that was written; a file is made safe from power cuts by
    /// that.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn to<W: Write + Send + 'static>(output: W) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let ours = Arc::clone(&shared);
        let job = move || {
            let mut output = Output::new(output);
            loop {
                let (batches, closed) = ours.next();
                let idle = batches.is_empty();
                for batch in batches {
                    if let Err(error) = output.write(&batch.bytes) {
                        ours.lose(batch.records, error);
                    }
                }
                if let (false, Err(error)) = (idle, output.flush()) {
                    ours.lose(0, error);
                }
                if closed {
                    return;
                }
            }
        };
        let thread = thread::Builder::new().name("tlog".into()).spawn(job)?;
        Ok(Self { shared, thread: Some(thread), notes: 0 })
    }

    /// Records a frame that was sent or received at this time, microseconds since 1970.
    ///
    /// What was recorded is safe on the disk less than a second later, or when this is dropped.
    pub fn record(&mut self, unix_us: u64, frame: &Frame) {
        if frame.message_id() == SETUP_SIGNING {
            return;
        }
        let mut queue = self.shared.queue();
        queue.open.bytes.extend_from_slice(&unix_us.to_be_bytes());
        queue.open.bytes.extend_from_slice(frame.bytes());
        queue.open.records += 1;
        if queue.open.bytes.len() + TIME + MAX_LEN > BATCH {
            let batch = std::mem::take(&mut queue.open);
            if queue.full.len() < WAITING {
                queue.full.push_back(batch);
                self.shared.wake.notify_one();
            } else {
                drop(queue);
                self.shared.lose(batch.records, io::Error::other("the disk is too slow"));
            }
        }
    }

    /// Records a note of the node with this MAVLink system.
    pub fn note(&mut self, unix_us: u64, system: u8, note: &Note) {
        self.notes = self.notes.checked_add(1).unwrap_or(1);
        // Its frames are none of the node's own numbering.
        let mut encoder = Encoder::new(system, NOTE_COMPONENT);
        for frame in note.frames(&mut encoder, self.notes) {
            self.record(unix_us, &frame);
        }
    }

    /// Hands what was recorded to the disk, without waiting for it.
    pub fn flush(&mut self) {
        self.shared.queue().hurry = true;
        self.shared.wake.notify_one();
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
        self.shared.queue().closed = true;
        self.shared.wake.notify_one();
        if let Some(Err(_)) = self.thread.take().map(JoinHandle::join) {
            self.shared.lose(0, io::Error::other("the recorder has ended"));
        }
    }
}

impl Shared {
    fn queue(&self) -> std::sync::MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for something to write, at most for [`EVERY`]; says whether that was all.
    fn next(&self) -> (Vec<Batch>, bool) {
        let idle = |queue: &mut Queue| queue.full.is_empty() && !queue.hurry && !queue.closed;
        let waited = self.wake.wait_timeout_while(self.queue(), EVERY, idle);
        let (mut queue, _) = waited.unwrap_or_else(PoisonError::into_inner);
        queue.hurry = false;
        let mut batches: Vec<_> = queue.full.drain(..).collect();
        batches.extend(Some(std::mem::take(&mut queue.open)).filter(|open| open.records > 0));
        (batches, queue.closed)
    }

    fn lose(&self, records: u64, error: io::Error) {
        self.lost.fetch_add(records, Ordering::Relaxed);
        *self.error.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
    }
}
