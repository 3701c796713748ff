//! Programs that are held at a point of their own, so that nothing depends on how fast they are.

use rustix::fs::{Mode, mkfifoat};
use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

/// Makes a pipe (FIFO) at `path`. Once a program reads it, `opened` returns; the program goes on when what that
/// returned is dropped.
///
/// # Errors
/// The folder takes no pipes.
pub fn held(path: &Path) -> io::Result<impl FnOnce() -> io::Result<File>> {
    mkfifoat(rustix::fs::CWD, path, Mode::RUSR | Mode::WUSR)?;
    let path = path.to_owned();
    // Opening it for writing waits for the reader.
    Ok(move || OpenOptions::new().write(true).open(path))
}
