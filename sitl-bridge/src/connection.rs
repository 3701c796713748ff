//! The byte link to an autopilot: UDP, TCP or a serial line, named by the strings that
//! MAVProxy, pymavlink, MAVSDK and QGroundControl users write.
//!
//! Nothing here blocks. A [`Connection`] that can break (TCP, a USB serial adapter) mends
//! itself: each [`Connection::recv`] tries again once a second. What the bytes mean is
//! [`crate::frame`]'s business; whose bytes are answered is the caller's, who confirms a
//! [`Peer`] once a frame of it was believed.

mod address;
mod error;
mod stream;
mod udp;

pub use address::{Address, AddressError};
pub use error::OpenError;

use crate::frame::Source;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io;
use std::net::{SocketAddr, ToSocketAddrs as _};
use std::os::fd::BorrowedFd;
use std::time::Duration;
use stream::StreamLink;
use udp::UdpLink;

/// A receive buffer of this length holds every datagram that a MAVLink sender makes, bytes.
pub const RECEIVE_LEN: usize = 2048;

/// An open link.
#[derive(Debug)]
pub struct Connection {
    link: Link,
}

#[derive(Debug)]
enum Link {
    Udp(UdpLink),
    Stream(StreamLink),
}

/// Where bytes came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer(Option<SocketAddr>);

/// What [`Connection::recv`] found.
#[derive(Debug)]
pub enum Received {
    /// Nothing is there.
    Nothing,
    /// This many bytes are in the buffer: a datagram, or a piece of the stream.
    Bytes {
        /// How many.
        len: usize,
        /// From whom.
        peer: Peer,
    },
    /// The stream is there (again): forget half frames of before.
    Connected,
    /// The stream broke, for this reason; it is being mended.
    Lost(io::Error),
}

/// What became of bytes to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sent {
    /// They are on their way.
    Yes,
    /// Nobody is there to send to: no peer was heard yet, or the stream is broken.
    NoPeer,
    /// The line is full. They were dropped: by the time it is free they would be stale.
    Full,
}

impl Connection {
    /// Opens the link. A TCP server that is not there yet is waited for in the background; a
    /// name that nobody knows, a port that is taken or a serial line that is missing is an error.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn open(address: &Address) -> Result<Self, OpenError> {
        let link = match address {
            Address::UdpIn { host, port } => Link::Udp(UdpLink::listen(host, *port)?),
            Address::UdpOut { host, port } => Link::Udp(UdpLink::to(host, *port)?),
            Address::Tcp { host, port } => Link::Stream(StreamLink::connect(host, *port)?),
            Address::TcpIn { host, port } => Link::Stream(StreamLink::accept(host, *port)?),
            Address::Serial { path, baud } => Link::Stream(StreamLink::serial(path, *baud)?),
        };
        Ok(Self { link })
    }

    /// Whether frames arrive whole or in pieces.
    #[must_use]
    pub const fn source(&self) -> Source {
        match self.link {
            Link::Udp(_) => Source::Datagrams,
            Link::Stream(_) => Source::Stream,
        }
    }

    /// Takes what arrived next; never waits. A datagram longer than `buffer` is cut, so give it
    /// [`RECEIVE_LEN`] bytes.
    ///
    /// # Errors
    /// The socket itself fails. A stream that breaks is [`Received::Lost`] instead.
    pub fn recv(&mut self, buffer: &mut [u8]) -> io::Result<Received> {
        match &mut self.link {
            Link::Udp(link) => link.recv(buffer),
            Link::Stream(link) => Ok(link.recv(buffer)),
        }
    }

    /// Says that a frame from this peer was believed. A listening link answers the peer that
    /// was confirmed last, so a stranger's bytes never turn the answers away.
    pub fn confirm(&mut self, peer: Peer) {
        if let Link::Udp(link) = &mut self.link {
            link.confirm(peer);
        }
    }

    /// Sends one or more whole frames; never waits.
    ///
    /// # Errors
    /// The network refuses them, as when the route is gone.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<Sent> {
        match &mut self.link {
            Link::Udp(link) => link.send(bytes),
            Link::Stream(link) => Ok(link.send(bytes)),
        }
    }

    /// What to wait on with [`wait`]; `None` while a stream is broken.
    #[must_use]
    pub fn watch(&self) -> Option<Watch<'_>> {
        match &self.link {
            Link::Udp(link) => Some(link.watch()),
            Link::Stream(link) => link.watch(),
        }
    }

    /// Where it listens, with the port that was really given when 0 was asked for; `None` of a
    /// link that listens nowhere.
    #[must_use]
    pub fn listens_on(&self) -> Option<SocketAddr> {
        match &self.link {
            Link::Udp(link) => link.listens_on(),
            Link::Stream(link) => link.listens_on(),
        }
    }

    /// What it does now, for a person: `listening on udp 0.0.0.0:14550`.
    #[must_use]
    pub fn describe(&self) -> String {
        match &self.link {
            Link::Udp(link) => link.describe(),
            Link::Stream(link) => link.describe(),
        }
    }

    /// What to check when nothing is heard on it.
    #[must_use]
    pub fn advice(&self) -> String {
        match &self.link {
            Link::Udp(link) => link.advice(),
            Link::Stream(link) => link.advice(),
        }
    }
}

/// Something to wait on.
#[derive(Clone, Copy, Debug)]
pub struct Watch<'a> {
    /// The socket or line.
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

/// The addresses of a host, IPv4 first, as simulators and radios mostly use it.
fn resolve(host: &str, port: u16) -> Result<Vec<SocketAddr>, OpenError> {
    let failed = |source| OpenError::Resolve { host: host.into(), source };
    let mut addresses: Vec<_> = (host, port).to_socket_addrs().map_err(failed)?.collect();
    addresses.sort_by_key(SocketAddr::is_ipv6);
    if addresses.is_empty() { Err(failed(io::ErrorKind::NotFound.into())) } else { Ok(addresses) }
}
