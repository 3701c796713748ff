//! Metrics as JSON lines: one object a line, appended and flushed row by row.
//!
//! A row is complete once its newline is written. A process killed in the middle of
//! a row leaves a tail without one; readers drop it and [`MetricsLog::resume`]
//! cuts it off. Numbers that are not finite become `null` (JSON has no other word);
//! [`nan_as_null`] reads them back.
//!
//! To make a resumed run's file the same to the byte, keep wall-clock times out of
//! the rows and call [`MetricsLog::sync`] before each checkpoint is written.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Serialize, de::DeserializeOwned};

use crate::atomic::advice;

/// What can go wrong with a metrics file.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// The file could not be opened, read or written.
    #[error("cannot {action} the metrics file {}. {help}", path.display())]
    File {
        /// What was being done.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What to do about it.
        help: String,
        /// What the operating system said.
        source: io::Error,
    },
    /// A complete row is not what was asked for.
    #[error("row {row} of {} cannot be read. Restore the file or delete that line", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// The row, counted from 1 as editors count lines.
        row: u64,
        /// What the parser said.
        source: serde_json::Error,
    },
    /// A value cannot be written as JSON.
    #[error("a row for {} cannot be written as JSON", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the serialiser said.
        source: serde_json::Error,
    },
    /// Fewer rows are there than a checkpoint says were written.
    #[error(
        "{} has {found} complete rows, but the checkpoint was taken after row {wanted}. Resume from an earlier checkpoint",
        path.display()
    )]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Rows in the file.
        found: u64,
        /// Rows that were asked for.
        wanted: u64,
    },
}

/// What the log needs of its file, so that a test can fill the disk.
trait Medium: Read + Write + Seek + Send {
    fn set_len(&self, length: u64) -> io::Result<()>;
    fn sync_data(&self) -> io::Result<()>;
}

impl Medium for File {
    fn set_len(&self, length: u64) -> io::Result<()> {
        Self::set_len(self, length)
    }
    fn sync_data(&self) -> io::Result<()> {
        Self::sync_data(self)
    }
}

/// Appends rows to a metrics file.
pub struct MetricsLog {
    file: Box<dyn Medium>,
    path: PathBuf,
    /// Complete rows in the file.
    rows: u64,
    /// Length of those rows, bytes.
    length: u64,
    /// Reused for each line.
    line: Vec<u8>,
}

impl MetricsLog {
    /// Starts a new, empty file.
    ///
    /// # Errors
    /// [`MetricsError::File`], also when the file exists: metrics are never overwritten.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, MetricsError> {
        let path = path.into();
        let opened = OpenOptions::new().read(true).write(true).create_new(true).open(&path);
        match opened {
            Ok(file) => Ok(Self::on(Box::new(file), path)),
            Err(source) => Err(file_error("create", &path, source)),
        }
    }

    /// Opens the file of an interrupted run and keeps its first `rows` rows, those
    /// that the checkpoint knows; the rest, complete or not, is cut off.
    ///
    /// # Errors
    /// [`MetricsError::TooShort`] when the file has fewer, or [`MetricsError::File`].
    pub fn resume(path: impl Into<PathBuf>, rows: u64) -> Result<Self, MetricsError> {
        let path = path.into();
        let opened = OpenOptions::new().read(true).write(true).open(&path);
        let file = opened.map_err(|e| file_error("open", &path, e))?;
        let mut log = Self::on(Box::new(file), path);
        log.truncate_to(rows)?;
        Ok(log)
    }

    fn on(file: Box<dyn Medium>, path: PathBuf) -> Self {
        Self { file, path, rows: 0, length: 0, line: Vec::new() }
    }

    /// Adds one row and hands it to the operating system at once.
    ///
    /// # Errors
    /// [`MetricsError::Encode`] or [`MetricsError::File`]; what was written of the
    /// row is taken back, so that the next row starts on a line of its own.
    pub fn append<T: Serialize + ?Sized>(&mut self, row: &T) -> Result<(), MetricsError> {
        self.line.clear();
        serde_json::to_writer(&mut self.line, row)
            .map_err(|source| MetricsError::Encode { path: self.path.clone(), source })?;
        self.line.push(b'\n');
        if let Err(source) = self.file.write_all(&self.line) {
            let taken_back = self.file.set_len(self.length).and_then(|()| self.file.seek(SeekFrom::End(0)));
            return Err(file_error("write", &self.path, taken_back.err().unwrap_or(source)));
        }
        self.rows += 1;
        self.length += self.line.len() as u64;
        Ok(())
    }

    /// Complete rows so far: what a checkpoint has to remember.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Returns once every row is on the medium. A checkpoint written after this
    /// never knows more rows than the file has.
    ///
    /// # Errors
    /// [`MetricsError::File`].
    pub fn sync(&self) -> Result<(), MetricsError> {
        self.file.sync_data().map_err(|e| file_error("sync", &self.path, e))
    }

    /// Keeps the first `rows` rows and drops what follows.
    ///
    /// # Errors
    /// [`MetricsError::TooShort`] when the file has fewer (it is then unchanged), or
    /// [`MetricsError::File`].
    pub fn truncate_to(&mut self, rows: u64) -> Result<(), MetricsError> {
        let mut bytes = Vec::new();
        let read = self.file.rewind().and_then(|()| self.file.read_to_end(&mut bytes));
        read.map_err(|e| file_error("read", &self.path, e))?;
        let length = match rows {
            0 => Some(0),
            n => newlines(&bytes).nth(usize::try_from(n - 1).unwrap_or(usize::MAX)).map(|at| at + 1),
        };
        let Some(length) = length else {
            let found = newlines(&bytes).count() as u64;
            return Err(MetricsError::TooShort { path: self.path.clone(), found, wanted: rows });
        };
        let cut = self.file.set_len(length as u64).and_then(|()| self.file.seek(SeekFrom::End(0)));
        cut.map_err(|e| file_error("cut", &self.path, e))?;
        (self.rows, self.length) = (rows, length as u64);
        Ok(())
    }
}

impl fmt::Debug for MetricsLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MetricsLog").field("path", &self.path).field("rows", &self.rows).finish_non_exhaustive()
    }
}

/// Reads every complete row. A last line without a newline is no row yet and is
/// left out: the run may still be writing it, or was killed while it did.
///
/// # Errors
/// [`MetricsError::Row`] when a complete row is not a `T`, or [`MetricsError::File`].
pub fn read<T: DeserializeOwned>(path: impl AsRef<Path>) -> Result<Vec<T>, MetricsError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|e| file_error("read", path, e))?;
    let complete = newlines(&bytes).last().map_or(0, |at| at + 1);
    let lines = bytes[..complete].split_inclusive(|&b| b == b'\n');
    let row = |(index, line)| {
        serde_json::from_slice(line).map_err(|source| MetricsError::Row {
            path: path.into(),
            row: index as u64 + 1,
            source,
        })
    };
    lines.enumerate().map(row).collect()
}

fn newlines(bytes: &[u8]) -> impl Iterator<Item = usize> {
    bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(at, _)| at)
}

fn file_error(action: &'static str, path: &Path, source: io::Error) -> MetricsError {
    let help = match source.kind() {
        io::ErrorKind::AlreadyExists => "Resume that run, or choose another run folder".into(),
        io::ErrorKind::NotFound if action != "create" => "Check that this is a run folder".into(),
        _ => advice(&source, &path.parent().unwrap_or(Path::new(".")).display().to_string()),
    };
    MetricsError::File { action, path: path.into(), help, source }
}

/// For `#[serde(with = "covey_report::metrics::nan_as_null")]` on an `f64`: numbers
/// that are not finite are written as `null` and `null` is read as NaN.
pub mod nan_as_null {
    use serde::{Deserialize, Deserializer, Serializer};

    /// Writes the number, or `null` when it is not finite.
    ///
    /// # Errors
    /// As the serialiser says.
    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.serialize_none() }
    }

    /// Reads a number, or NaN for `null`.
    ///
    /// # Errors
    /// When there is something else.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// A file on a disk with room for so many more bytes.
    struct SmallDisk {
        file: File,
        room: Cell<u64>,
    }

    impl Read for SmallDisk {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            self.file.read(bytes)
        }
    }

    impl Seek for SmallDisk {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.file.seek(to)
        }
    }

    impl Write for SmallDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let n = bytes.len().min(self.room.get() as usize);
            self.room.set(self.room.get() - n as u64);
            if n == 0 { Err(io::ErrorKind::StorageFull.into()) } else { self.file.write(&bytes[..n]) }
        }
        fn flush(&mut self) -> io::Result<()> {
            self.file.flush()
        }
    }

    impl Medium for SmallDisk {
        fn set_len(&self, length: u64) -> io::Result<()> {
            self.room.set(self.room.get() + self.file.metadata()?.len() - length);
            self.file.set_len(length)
        }
        fn sync_data(&self) -> io::Result<()> {
            self.file.sync_data()
        }
    }

    #[test]
    fn a_full_disk_leaves_whole_rows_and_the_next_row_starts_on_its_own_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.jsonl");
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&path).unwrap();
        let mut log = MetricsLog::on(Box::new(SmallDisk { file, room: Cell::new(9) }), path.clone());
        log.append(&[1, 2]).unwrap();
        let error = log.append(&[3, 4]).unwrap_err();
        assert!(error.to_string().contains("Free space on the disk"), "{error}");
        log.append(&7).unwrap();
        assert_eq!((std::fs::read_to_string(&path).unwrap().as_str(), log.rows()), ("[1,2]\n7\n", 2));
    }
}
