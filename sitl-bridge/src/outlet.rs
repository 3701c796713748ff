//! Standard output and error that keep nobody waiting.
//!
//! A pipe that nobody reads, or a terminal that was stopped, blocks whoever writes to it. A flight must not wait
//! for its reader: lines go into a bounded queue that a thread of its own writes out. What finds the queue full is
//! dropped, counted and told of once it goes on.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

/// Most bytes that wait to be written.
const MOST_WAITING: usize = 1 << 18;
/// How long the end of the program waits for a reader.
const PARTING: Duration = Duration::from_secs(1);

/// What is written in place of so many lost lines.
type Lost = fn(u64) -> String;

/// An output behind a queue.
#[derive(Clone)]
pub struct Outlet {
    shared: Arc<Shared>,
}

struct Shared {
    queue: Mutex<Queue>,
    /// Something was added, or written out.
    changed: Condvar,
    lost: Lost,
}

#[derive(Default)]
struct Queue {
    waiting: VecDeque<String>,
    /// Bytes of what waits.
    bytes: usize,
    /// Lines that found no room since the last that did.
    lost: u64,
    /// A text is being written.
    busy: bool,
    /// Its reader is gone: nothing is kept for it.
    closed: bool,
}

impl Outlet {
    /// Writes to `sink` in a thread of its own. `lost` makes the line that tells of so many lost ones.
    #[must_use]
    pub fn new(sink: Box<dyn Write + Send>, lost: Lost) -> Self {
        let shared = Arc::new(Shared { queue: Mutex::default(), changed: Condvar::new(), lost });
        let writer = Arc::clone(&shared);
        thread::spawn(move || writer.write_out(sink));
        Self { shared }
    }

    /// Adds a text, whole lines; says whether there was room for it. Never waits for the reader.
    pub fn write(&self, text: impl Into<String>) -> bool {
        let mut queue = self.shared.lock();
        let text = text.into();
        if queue.closed {
            return true;
        }
        if queue.bytes + text.len() > MOST_WAITING && !queue.waiting.is_empty() {
            queue.lost += 1;
            return false;
        }
        self.shared.tell_lost(&mut queue);
        queue.add(text);
        self.shared.changed.notify_all();
        true
    }

    /// Adds a text unless others still wait: one that the next will replace. Says whether it was added.
    pub fn offer(&self, text: impl Into<String>) -> bool {
        let queue = self.shared.lock();
        let behind = queue.busy || !queue.waiting.is_empty();
        drop(queue);
        !behind && self.write(text)
    }

    /// Waits until all is written, at most for `patience`; says whether it is.
    pub fn drain(&self, patience: Duration) -> bool {
        let queue = self.shared.lock();
        let waits = |queue: &mut Queue| !queue.closed && (queue.busy || !queue.waiting.is_empty() || queue.lost > 0);
        let waited = self.shared.changed.wait_timeout_while(queue, patience, waits);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Lines that were lost since the last that found room.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.shared.lock().lost
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where lines were lost it is said so.
    fn tell_lost(&self, queue: &mut Queue) {
        let lost = std::mem::take(&mut queue.lost);
        if lost > 0 {
            queue.add((self.lost)(lost));
        }
    }

    fn write_out(&self, mut sink: Box<dyn Write + Send>) {
        loop {
            let mut queue = self.lock();
            while queue.waiting.is_empty() && queue.lost == 0 {
                queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
            }
            if queue.waiting.is_empty() {
                self.tell_lost(&mut queue);
            }
            let text = queue.waiting.pop_front().unwrap_or_default();
            (queue.bytes, queue.busy) = (queue.bytes - text.len(), true);
            drop(queue);
            // Where the output is closed or its disk full, the flight and the other output go on.
            let written = sink.write_all(text.as_bytes()).and_then(|()| sink.flush());
            let mut queue = self.lock();
            queue.busy = false;
            if written.is_err_and(|error| error.kind() == io::ErrorKind::BrokenPipe) {
                (queue.closed, queue.waiting, queue.bytes) = (true, VecDeque::new(), 0);
            }
            self.changed.notify_all();
        }
    }
}

impl Queue {
    fn add(&mut self, text: String) {
        self.bytes += text.len();
        self.waiting.push_back(text);
    }
}

/// Standard error.
pub fn stderr() -> &'static Outlet {
    static STDERR: OnceLock<Outlet> = OnceLock::new();
    STDERR.get_or_init(|| {
        Outlet::new(Box::new(io::stderr()), |lost| {
            format!("warning: {lost} lines were lost: nobody read this output\n")
        })
    })
}

/// Standard output, as lines of JSON.
pub fn stdout() -> &'static Outlet {
    static STDOUT: OnceLock<Outlet> = OnceLock::new();
    STDOUT.get_or_init(|| Outlet::new(Box::new(io::stdout()), |lost| format!("{{\"lost_lines\":{lost}}}\n")))
}

/// A line for the operator on standard error.
pub fn say(line: &str) {
    stderr().write(format!("{line}\n"));
}

/// Gives both outputs time to be read, at the end of the program.
pub fn drain() {
    stdout().drain(PARTING);
    stderr().drain(PARTING);
}
