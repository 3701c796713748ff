//! Errors of opening a link, and what to do about them.

use std::io::{self, ErrorKind};
use std::path::PathBuf;
use thiserror::Error;

/// Why a link cannot be opened.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The host's name is unknown.
    #[error("cannot find the host `{host}`: check its spelling, or write its number")]
    Resolve {
        /// The name.
        host: String,
        /// The system's error.
        source: io::Error,
    },
    /// The own address or port is not available.
    #[error("cannot listen on {address}: {}", bind_hint(source))]
    Bind {
        /// Address and port.
        address: String,
        /// The system's error.
        source: io::Error,
    },
    /// The other end cannot be reached.
    #[error("cannot send to {address}: is the network up?")]
    Connect {
        /// Address and port.
        address: String,
        /// The system's error.
        source: io::Error,
    },
    /// The serial line cannot be used.
    #[error("cannot open the serial line {}: {}", path.display(), serial_hint(source))]
    Serial {
        /// The device.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
}

fn bind_hint(source: &io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::AddrInUse => "another program listens there; take another port, or port 0 for a free one",
        ErrorKind::AddrNotAvailable => "this computer has no such address; 0.0.0.0 means all it has",
        ErrorKind::PermissionDenied => "ports below 1024 are for administrators; take a higher one",
        _ => "the system refuses",
    }
}

fn serial_hint(source: &io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::NotFound => "there is no such device; is the cable in? `ls /dev/tty*` shows what there is",
        ErrorKind::PermissionDenied => "this user may not use it; `sudo usermod -aG dialout $USER`, then log in again",
        ErrorKind::ResourceBusy => "another program has it open",
        _ => "it is no serial line, or does not take this speed",
    }
}
