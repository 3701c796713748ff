//! Waiting for sockets and serial lines with poll(2).

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io;
use std::os::fd::BorrowedFd;
use std::time::Duration;

/// A socket or serial line to wait on with [`wait`].
#[derive(Clone, Copy, Debug)]
pub struct Watch<'a> {
    /// Its file descriptor.
    pub fd: BorrowedFd<'a>,
    /// Whether it waits for room to write, besides for bytes to read.
    pub writes: bool,
}

/// Waits until one of them has something to do, at most `timeout`. A signal may end it early.
///
/// # Errors
/// The system's poll fails.
pub fn wait(watched: &[Watch<'_>], timeout: Duration) -> io::Result<()> {
    let flags = |w: &Watch<'_>| if w.writes { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
    let mut fds: Vec<_> = watched.iter().map(|w| PollFd::from_borrowed_fd(w.fd, flags(w))).collect();
    let timeout = Timespec::try_from(timeout).map_err(|_| io::ErrorKind::InvalidInput)?;
    match poll(&mut fds, Some(&timeout)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}
