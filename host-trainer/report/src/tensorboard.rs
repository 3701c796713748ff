//! TensorBoard event files.
//!
//! A file is a row of TFRecords: length (u64), masked CRC of the length (u32), data,
//! masked CRC of the data (u32), all little-endian; CRC-32C, masked as
//! `rotate_right(crc, 15) + 0xa282ead8`. The data is an `Event` of TensorFlow's
//! `event.proto`, of which six fields are written, encoded here by hand:
//!
//! | message | field | number | wire type |
//! |---|---|---|---|
//! | Event | wall_time, seconds (double) | 1 | 64-bit |
//! | Event | step (int64) | 2 | varint |
//! | Event | file_version (string), in the first event | 3 | bytes |
//! | Event | summary (Summary) | 5 | bytes |
//! | Event | session_log (SessionLog: status = 1, START) | 7 | bytes |
//! | Summary | value (Value: tag = 1, simple_value = 2, float) | 1 | bytes |

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crc::{CRC_32_ISCSI, Crc};

use crate::io_advice::advice;

const CASTAGNOLI: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// The beginning of the name of every event file; TensorBoard reads them in the order of their names.
const PREFIX: &str = "events.out.tfevents.";

/// An event file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write TensorBoard events in {}. {help}", path.display())]
pub struct EventError {
    /// The file or folder.
    pub path: PathBuf,
    /// What to do about it.
    pub help: String,
    /// What the operating system reported.
    pub source: io::Error,
}

/// Writes one event file.
#[derive(Debug)]
pub struct EventWriter {
    file: BufWriter<File>,
    path: PathBuf,
    /// Reused for each event.
    event: Vec<u8>,
}

impl EventWriter {
    /// Starts a new event file in `folder` (made if missing), after those that are
    /// there: a resumed run adds a file and leaves the earlier ones alone.
    /// `wall_time_s` is the time now, in seconds since 1970.
    ///
    /// # Errors
    /// [`EventError`] when the folder or the file cannot be made.
    pub fn create(folder: impl AsRef<Path>, wall_time_s: f64) -> Result<Self, EventError> {
        let folder = folder.as_ref();
        let failed = |e| event_error(folder, e);
        fs::create_dir_all(folder).map_err(failed)?;
        let path = folder.join(format!("{PREFIX}{:010}.covey", last_number(folder).map_err(failed)? + 1));
        let file = OpenOptions::new().write(true).create_new(true).open(&path).map_err(failed)?;
        let mut writer = Self { file: BufWriter::new(file), path, event: Vec::new() };
        writer.begin(wall_time_s, 0);
        put_bytes(&mut writer.event, 3, b"brain.Event:2");
        writer.end()?;
        Ok(writer)
    }

    /// Tells TensorBoard that a run is resumed from a checkpoint: points of earlier files at `step` and later are void
    /// and will be written again.
    ///
    /// # Errors
    /// [`EventError`].
    pub fn resumed_at(&mut self, step: u64, wall_time_s: f64) -> Result<(), EventError> {
        self.begin(wall_time_s, step);
        put_bytes(&mut self.event, 7, &[1 << 3, 1]);
        self.end()
    }

    /// Adds one point of the curve `tag` (slashes group curves). `wall_time_s` is in
    /// seconds since 1970.
    ///
    /// # Errors
    /// [`EventError`].
    pub fn scalar(&mut self, tag: &str, step: u64, wall_time_s: f64, value: f32) -> Result<(), EventError> {
        let mut point = Vec::with_capacity(tag.len() + 16);
        put_bytes(&mut point, 1, tag.as_bytes());
        point.push(2 << 3 | 5);
        point.extend(value.to_le_bytes());
        let mut summary = Vec::with_capacity(point.len() + 4);
        put_bytes(&mut summary, 1, &point);
        self.begin(wall_time_s, step);
        put_bytes(&mut self.event, 5, &summary);
        self.end()
    }

    /// Hands every event so far to the operating system. Dropping the writer does
    /// so too, but cannot report an error.
    ///
    /// # Errors
    /// [`EventError`].
    pub fn flush(&mut self) -> Result<(), EventError> {
        self.file.flush().map_err(|e| event_error(&self.path, e))
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn begin(&mut self, wall_time_s: f64, step: u64) {
        self.event.clear();
        self.event.push(1 << 3 | 1);
        self.event.extend(wall_time_s.to_le_bytes());
        self.event.push(2 << 3);
        put_varint(&mut self.event, step);
    }

    fn end(&mut self) -> Result<(), EventError> {
        let length = (self.event.len() as u64).to_le_bytes();
        let mut put = |bytes: &[u8]| self.file.write_all(bytes);
        put(&length)
            .and_then(|()| put(&masked_crc(&length).to_le_bytes()))
            .and_then(|()| put(&self.event))
            .and_then(|()| put(&masked_crc(&self.event).to_le_bytes()))
            .map_err(|e| event_error(&self.path, e))
    }
}

/// CRC-32C as TFRecord stores it.
fn masked_crc(bytes: &[u8]) -> u32 {
    CASTAGNOLI.checksum(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

fn put_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn put_bytes(out: &mut Vec<u8>, field: u8, bytes: &[u8]) {
    out.push(field << 3 | 2);
    put_varint(out, bytes.len() as u64);
    out.extend_from_slice(bytes);
}

/// Highest number among the event files of `folder`, 0 when there is none.
fn last_number(folder: &Path) -> io::Result<u64> {
    let mut last = 0;
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let number = name.to_str().and_then(|n| n.strip_prefix(PREFIX)?.split('.').next()?.parse().ok());
        last = last.max(number.unwrap_or(0));
    }
    Ok(last)
}

fn event_error(path: &Path, source: io::Error) -> EventError {
    EventError { path: path.into(), help: advice(&source, &path.display().to_string()), source }
}
