//! Timestamps that survive a restart: those that were issued, and the newest of each sender.
//!
//! The file holds the time up to which timestamps may have been issued. It is written ahead, a block of
//! time at once, so that signing itself never waits for a disk; a session that starts from it begins
//! behind the whole block. Each block is written with the newest timestamp of each sender.

use super::timestamp::Timestamp;
use covey_report::atomic;
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use thiserror::Error;

/// The block of time that is reserved at once.
const BLOCK: Duration = Duration::from_secs(60);
/// The next block is reserved when less than this is left.
const MARGIN: Duration = Duration::from_secs(30);
/// After a failure it is tried again after this.
const RETRY: Duration = Duration::from_secs(5);
/// The first line; times follow in units of 10 µs since 2015.
const HEAD: &str = "covey signing state 1";
/// The last line: a file without it was cut.
const END: &str = "end\n";

/// Why a state file cannot be used.
#[derive(Debug, Error)]
pub enum StateFileError {
    /// It cannot be read.
    #[error("cannot read the signing state {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// It cannot be written, so a restart would repeat timestamps.
    #[error("cannot write the signing state {}: name a file in a folder that this user may write", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Its content is damaged.
    #[error(
        "{} is no signing state: delete it once the system's clock is right and later than at the last flight",
        .0.display()
    )]
    Damaged(PathBuf),
    /// Another process uses it.
    #[error("the signing state {} is in use by another process: give every node its own", .0.display())]
    InUse(PathBuf),
}

/// A file that keeps a [`super::Session`]'s time.
#[derive(Debug)]
pub struct StateFile {
    path: PathBuf,
    /// The lock that keeps other processes from using the file.
    _lock: File,
    shared: Arc<Mutex<Shared>>,
    writer: Option<JoinHandle<()>>,
    /// When writing a block was last attempted.
    tried: Timestamp,
}

/// The newest authenticated timestamp of each (system, component, link id).
pub(super) type Streams = BTreeMap<(u8, u8, u8), Timestamp>;

/// The file's content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Saved {
    /// The session's time when it was written.
    time: Timestamp,
    /// Timestamps up to here may have been issued.
    reserved: Timestamp,
    /// The newest timestamp of each sender.
    streams: Streams,
}

#[derive(Debug)]
struct Shared {
    saved: Saved,
    error: Option<String>,
}

impl StateFile {
    /// Opens the file, which need not exist yet, and takes it for this process.
    ///
    /// # Errors
    /// See [`StateFileError`].
    pub fn open(path: &Path) -> Result<Self, StateFileError> {
        let write = |source| StateFileError::Write { path: path.into(), source };
        let lock = File::options().create(true).append(true).open(beside(path, "lock")).map_err(write)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StateFileError::InUse(path.into())),
            Err(TryLockError::Error(source)) => return Err(write(source)),
        }
        let saved = match fs::read_to_string(path) {
            Ok(text) => parse(&text).ok_or_else(|| StateFileError::Damaged(path.into()))?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Saved::default(),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                return Err(StateFileError::Damaged(path.into()));
            }
            Err(source) => return Err(StateFileError::Read { path: path.into(), source }),
        };
        let shared = Arc::new(Mutex::new(Shared { saved, error: None }));
        Ok(Self { path: path.into(), _lock: lock, shared, writer: None, tried: Timestamp::default() })
    }

    /// Timestamps up to here may have been issued before.
    pub(super) fn reserved(&self) -> Timestamp {
        lock(&self.shared).saved.reserved
    }

    /// The session's time when it was written.
    pub(super) fn time(&self) -> Timestamp {
        lock(&self.shared).saved.time
    }

    /// The newest timestamp of each sender at that time.
    pub(super) fn streams(&self) -> Streams {
        lock(&self.shared).saved.streams.clone()
    }

    /// Reserves the block that begins at `next`, and waits until it is on the disk.
    pub(super) fn reserve(
        &mut self,
        time: Timestamp,
        next: Timestamp,
        streams: &Streams,
    ) -> Result<(), StateFileError> {
        let saved = Saved { time, reserved: next.after(BLOCK), streams: streams.clone() };
        write(&self.path, &saved).map_err(|source| StateFileError::Write { path: self.path.clone(), source })?;
        lock(&self.shared).saved = saved;
        Ok(())
    }

    /// Reserves the next block in the background when `issued` comes near the end of this one.
    ///
    /// A disk that fails in flight does not stop the flight: the error is kept, and the write is repeated
    /// later.
    pub(super) fn keep_ahead_of(&mut self, time: Timestamp, issued: Timestamp, streams: &Streams) {
        let enough = self.reserved() >= issued.after(MARGIN);
        if enough || time < self.tried.after(RETRY) || self.writer.as_ref().is_some_and(|w| !w.is_finished()) {
            return;
        }
        self.tried = time;
        let (path, shared) = (self.path.clone(), Arc::clone(&self.shared));
        let saved = Saved { time, reserved: issued.after(BLOCK), streams: streams.clone() };
        let job = move || {
            let written = write(&path, &saved);
            let mut shared = lock(&shared);
            match written {
                Ok(()) => *shared = Shared { saved, error: None },
                Err(error) => {
                    shared.error = Some(format!("cannot write the signing state {}: {error}", path.display()))
                }
            }
        };
        match thread::Builder::new().name("signing-state".into()).spawn(job) {
            Ok(writer) => self.writer = Some(writer),
            Err(error) => lock(&self.shared).error = Some(format!("cannot keep the signing state: {error}")),
        }
    }

    /// Writes the timestamps that were really used.
    pub(super) fn close(&mut self, time: Timestamp, issued: Timestamp, streams: Streams) {
        if let Some(writer) = self.writer.take() {
            // It returns nothing, and if it panicked, the block that it had reserved stands.
            drop(writer.join());
        }
        // When this fails, the block that was reserved stands: the next session begins behind it.
        drop(write(&self.path, &Saved { time, reserved: issued, streams }));
    }

    /// The error of the last write.
    pub(super) fn error(&self) -> Option<String> {
        lock(&self.shared).error.clone()
    }
}

fn lock(shared: &Mutex<Shared>) -> std::sync::MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Replaces the file as a whole: a crash leaves the old one or the new one.
fn write(path: &Path, saved: &Saved) -> io::Result<()> {
    let (time, reserved) = (saved.time.ticks(), saved.reserved.ticks());
    let mut text = format!("{HEAD}\ntime {time}\nreserved {reserved}\n");
    for ((system, component, link), newest) in &saved.streams {
        text += &format!("heard {system} {component} {link} {}\n", newest.ticks());
    }
    text += END;
    atomic::write(path, text.as_bytes()).map_err(|error| error.source)
}

fn parse(text: &str) -> Option<Saved> {
    let mut lines = text.strip_prefix(HEAD)?.strip_prefix('\n')?.strip_suffix(END)?.lines();
    let time = ticks(lines.next()?.strip_prefix("time ")?)?;
    let reserved = ticks(lines.next()?.strip_prefix("reserved ")?)?;
    let stream = |line: &str| {
        let mut fields = line.strip_prefix("heard ")?.split(' ');
        let mut byte = || fields.next()?.parse().ok();
        let stream = (byte()?, byte()?, byte()?);
        let newest = ticks(fields.next()?)?;
        fields.next().is_none().then_some((stream, newest))
    };
    let streams = lines.map(stream).collect::<Option<Streams>>()?;
    Some(Saved { time, reserved, streams })
}

/// A timestamp of 48 bits.
fn ticks(text: &str) -> Option<Timestamp> {
    let ticks = text.parse().ok()?;
    Some(Timestamp::from_ticks(ticks)).filter(|time| time.ticks() == ticks)
}

fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(suffix);
    name.into()
}
