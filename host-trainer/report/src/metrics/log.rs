//! Writing a metrics file row by row.

use super::error::{MetricsError, file_error};
use super::read::newlines;
use crate::sync::lived_with;
use serde::Serialize;
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

/// The file operations that the log needs; tests pass a disk that is full.
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
///
/// To make a resumed run's file the same to the byte, keep wall-clock times out of the rows and call
/// [`MetricsLog::sync`] before each checkpoint is written.
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

    /// Opens the file of an interrupted run and keeps its first `rows` rows, those written before its checkpoint; the
    /// rest, complete or not, is cut off.
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

    /// Appends one row and hands it to the operating system at once.
    ///
    /// # Errors [`MetricsError::Encode`] or [`MetricsError::File`]; a part of the row that was written is cut off
    /// again, so that the next row starts on a line of its own.
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

    /// Number of complete rows so far: what a checkpoint has to remember.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Returns once every row is on the storage medium, so that a checkpoint written after it never counts more rows
    /// than the file has.
    ///
    /// # Errors
    /// [`MetricsError::File`].
    pub fn sync(&self) -> Result<(), MetricsError> {
        lived_with(self.file.sync_data()).map_err(|e| file_error("sync", &self.path, e))
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
