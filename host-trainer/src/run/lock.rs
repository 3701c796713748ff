//! One run folder, one process: an advisory lock that the system takes off when its process ends, however it ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The lock's file in the run folder; it holds the id of the process that has the lock.
const FILE: &str = "run.lock";

/// Why a run folder cannot be locked.
#[derive(Debug, Error)]
pub enum LockError {
    /// Another process works on it.
    #[error("{path} is in use by {holder}; wait for its end, or stop it, then run the same command again")]
    InUse {
        /// The run folder.
        path: PathBuf,
        /// The other process, in words.
        holder: String,
    },
    /// The lock's file cannot be made.
    #[error("cannot write {path}; mend the permissions of the run folder, then run the same command again")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// A run folder that no other process can lock as long as this lives.
#[derive(Debug)]
pub struct RunLock {
    file: File,
    path: PathBuf,
    /// Whether the file system has locks at all.
    locked: bool,
}

impl RunLock {
    /// Locks an existing run folder. A file system without locks (a share, for example) is lived with: `warn` is
    /// then told so.
    ///
    /// # Errors
    /// [`LockError::InUse`] while another process, or another lock of this one, has it.
    pub fn take(folder: &Path, mut warn: impl FnMut(&str)) -> Result<Self, LockError> {
        let path = folder.join(FILE);
        let write = |source| LockError::Write { path: path.clone(), source };
        loop {
            let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).clone();
            let mut file = options.open(&path).map_err(write)?;
            let locked = match file.try_lock() {
                Ok(()) => true,
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::InUse { path: folder.to_owned(), holder: holder(&mut file) });
                }
                Err(TryLockError::Error(e)) if has_no_locks(&e) => {
                    warn(&format!(
                        "{} is on a file system without locks ({e}): take care that only one process uses it",
                        folder.display()
                    ));
                    false
                }
                Err(TryLockError::Error(e)) => return Err(write(e)),
            };
            // The one who had it may have removed the file after it was opened here.
            if locked && !is_still_at(&file, &path) {
                continue;
            }
            file.set_len(0).and_then(|()| write!(file, "{}", std::process::id())).map_err(write)?;
            return Ok(Self { file, path, locked });
        }
    }
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // A file that stays is only untidy: the lock is what counts. It is removed before the lock is taken off.
        let _ = std::fs::remove_file(&self.path);
        if self.locked {
            let _ = self.file.unlock();
        }
    }
}

fn holder(file: &mut File) -> String {
    let mut text = String::new();
    let read = file.rewind().and_then(|()| file.read_to_string(&mut text));
    match text.trim().parse::<u32>() {
        Ok(id) if read.is_ok() => format!("process {id}"),
        _ => "another process".to_owned(),
    }
}

/// Whether the file system says that it has no such operation.
fn has_no_locks(e: &io::Error) -> bool {
    #[cfg(unix)]
    let no_lock = e.raw_os_error() == Some(libc::ENOLCK);
    #[cfg(not(unix))]
    let no_lock = false;
    no_lock || matches!(e.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput)
}

#[cfg(unix)]
fn is_still_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |m: std::fs::Metadata| (m.dev(), m.ino());
    file.metadata().map(place).ok() == std::fs::metadata(path).map(place).ok()
}

/// Elsewhere an open file cannot be removed.
#[cfg(not(unix))]
fn is_still_at(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn what_says_that_there_are_no_locks() {
        for code in [libc::ENOLCK, libc::EOPNOTSUPP, libc::ENOSYS, libc::EINVAL] {
            assert!(has_no_locks(&io::Error::from_raw_os_error(code)), "{code}");
        }
        assert!(!has_no_locks(&io::Error::from_raw_os_error(libc::EIO)));
    }
}
