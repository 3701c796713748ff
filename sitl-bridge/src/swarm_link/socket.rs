//! The socket of the swarm link.

use super::address::SwarmAddress;
use crate::connection::{OpenError, Watch};
use socket2::{Domain, Protocol, Socket, Type};
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::os::fd::AsFd as _;

/// A non-blocking socket of the swarm link. Multicast and broadcast loop its own datagrams back;
/// [`super::SwarmLink`] recognises them.
#[derive(Debug)]
pub struct SwarmSocket {
    socket: UdpSocket,
    local: SocketAddr,
    to: Vec<SocketAddr>,
    address: SwarmAddress,
}

impl SwarmSocket {
    /// Opens the socket and joins the swarm. Several on one computer can share a multicast or
    /// broadcast port.
    ///
    /// # Errors
    /// [`OpenError::Bind`]: the port is taken, or this computer has no such address or network.
    pub fn open(address: &SwarmAddress) -> Result<Self, OpenError> {
        let (own, to) = match address {
            // Bound to the group, it receives no other datagrams of this port.
            SwarmAddress::Multicast { group, .. } => (SocketAddr::from(*group), vec![(*group).into()]),
            SwarmAddress::Broadcast { to } => ((Ipv4Addr::UNSPECIFIED, to.port()).into(), vec![(*to).into()]),
            SwarmAddress::Peers { listen, peers } => (*listen, peers.clone()),
        };
        let failed = |source| OpenError::Bind { address: own.to_string(), source };
        let socket = bind(own, address).map_err(failed)?;
        let local = socket.local_addr().map_err(failed)?;
        Ok(Self { socket, local, to, address: address.clone() })
    }

    /// Receives the next datagram and returns its length; `None` when there is none. One longer
    /// than `buffer` is cut, so give it [`crate::connection::RECEIVE_LEN`] bytes.
    ///
    /// # Errors
    /// The socket fails.
    pub fn recv(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        match self.socket.recv(buffer) {
            Ok(len) => Ok(Some(len)),
            Err(error) if is_nothing(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Sends a frame to all; never waits. A peer's failure does not keep it from the others.
    ///
    /// # Errors
    /// The last failure. Without a network nothing is sent; the swarm link tolerates that.
    pub fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut result = Ok(());
        for &to in &self.to {
            if let Err(error) = self.socket.send_to(frame, to) {
                result = Err(error);
            }
        }
        result
    }

    /// Replaces the list of peers, as when their ports are known only once they are open. By
    /// multicast or broadcast this sends to the peers besides.
    pub fn set_peers(&mut self, peers: &[SocketAddr]) {
        let always = match self.address {
            SwarmAddress::Peers { .. } => 0,
            SwarmAddress::Multicast { .. } | SwarmAddress::Broadcast { .. } => 1,
        };
        self.to.truncate(always);
        self.to.extend_from_slice(peers);
    }

    /// The address it listens on, with the port that the system chose where 0 was given.
    #[must_use]
    pub const fn listens_on(&self) -> SocketAddr {
        self.local
    }

    /// The descriptor to wait on with [`crate::connection::wait`].
    #[must_use]
    pub fn watch(&self) -> Watch<'_> {
        Watch { fd: self.socket.as_fd(), writes: false }
    }

    /// Its state in words.
    #[must_use]
    pub fn describe(&self) -> String {
        match &self.address {
            SwarmAddress::Multicast { group, interface } if interface.is_unspecified() => {
                format!("swarm by multicast on udp {group}")
            }
            SwarmAddress::Multicast { group, interface } => {
                format!("swarm by multicast on udp {group}, network of {interface}")
            }
            SwarmAddress::Broadcast { to } => format!("swarm by broadcast on udp {to}"),
            SwarmAddress::Peers { .. } => format!("swarm on udp {} with {} peers", self.local, self.to.len()),
        }
    }
}

fn bind(own: SocketAddr, address: &SwarmAddress) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::for_address(own), Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_nonblocking(true)?;
    match address {
        SwarmAddress::Multicast { group, interface } => {
            socket.set_reuse_address(true)?;
            socket.join_multicast_v4(group.ip(), interface)?;
            socket.set_multicast_if_v4(interface)?;
            // Nodes on this computer receive it too, and no router forwards it.
            socket.set_multicast_loop_v4(true)?;
            socket.set_multicast_ttl_v4(1)?;
        }
        SwarmAddress::Broadcast { .. } => {
            socket.set_reuse_address(true)?;
            socket.set_broadcast(true)?;
        }
        SwarmAddress::Peers { .. } => {}
    }
    socket.bind(&own.into())?;
    Ok(socket.into())
}

fn is_nothing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::ConnectionRefused | ErrorKind::Interrupted)
}
