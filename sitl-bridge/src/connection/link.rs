//! An open link of any kind.

use super::address::Address;
use super::error::OpenError;
use super::poll::Watch;
use super::stream::StreamLink;
use super::transfer::{Peer, Received, Sent};
use super::udp::UdpLink;
use crate::frame::Source;
use std::io;
use std::net::SocketAddr;

/// An open link to an autopilot.
#[derive(Debug)]
pub struct Connection {
    link: Link,
}

#[derive(Debug)]
enum Link {
    Udp(UdpLink),
    Stream(StreamLink),
}

impl Connection {
    /// Opens the link. A TCP server that is not running yet is tried again in the background; an
    /// unknown host name, a port in use or a missing serial line is an error.
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

    /// Receives the next bytes; never waits. A datagram longer than `buffer` is cut, so give it
    /// [`super::RECEIVE_LEN`] bytes.
    ///
    /// # Errors
    /// The socket itself fails. A stream that breaks is [`Received::Lost`] instead.
    pub fn recv(&mut self, buffer: &mut [u8]) -> io::Result<Received> {
        match &mut self.link {
            Link::Udp(link) => link.recv(buffer),
            Link::Stream(link) => Ok(link.recv(buffer)),
        }
    }

    /// Says that an authentic frame came from this peer. A listening UDP link sends to the peer
    /// that was confirmed last, so the bytes of a stranger never redirect what is sent.
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

    /// The descriptor to wait on with [`super::wait`]; `None` while a stream is broken.
    #[must_use]
    pub fn watch(&self) -> Option<Watch<'_>> {
        match &self.link {
            Link::Udp(link) => Some(link.watch()),
            Link::Stream(link) => link.watch(),
        }
    }

    /// The address it listens on, with the port that the system chose where 0 was given; `None` for a
    /// link that does not listen.
    #[must_use]
    pub fn listens_on(&self) -> Option<SocketAddr> {
        match &self.link {
            Link::Udp(link) => link.listens_on(),
            Link::Stream(link) => link.listens_on(),
        }
    }

    /// Its present state in words: `listening on udp 0.0.0.0:14550`.
    #[must_use]
    pub fn describe(&self) -> String {
        match &self.link {
            Link::Udp(link) => link.describe(),
            Link::Stream(link) => link.describe(),
        }
    }

    /// What a user should check when nothing is received on it.
    #[must_use]
    pub fn advice(&self) -> String {
        match &self.link {
            Link::Udp(link) => link.advice(),
            Link::Stream(link) => link.advice(),
        }
    }
}
