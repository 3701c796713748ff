//! UDP links.

use super::error::OpenError;
use super::poll::Watch;
use super::resolve::resolve;
use super::transfer::{Peer, Received, Sent};
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::os::fd::AsFd as _;

/// A UDP socket that listens, or that talks to one address.
#[derive(Debug)]
pub(super) struct UdpLink {
    socket: UdpSocket,
    local: SocketAddr,
    role: Role,
}

#[derive(Debug)]
enum Role {
    /// Sends to the peer that was confirmed last.
    Listens { peer: Option<SocketAddr> },
    /// A connected socket: the system drops datagrams of other senders.
    Sends { to: SocketAddr },
}

impl UdpLink {
    /// Listens on an address of this computer.
    pub(super) fn listen(host: &str, port: u16) -> Result<Self, OpenError> {
        let own = resolve(host, port)?[0];
        Self::bind(own, Role::Listens { peer: None })
    }

    /// A link that sends to and receives from one address.
    pub(super) fn to(host: &str, port: u16) -> Result<Self, OpenError> {
        let to = resolve(host, port)?[0];
        let own = match to {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let mut link = Self::bind(own, Role::Sends { to })?;
        let failed = |source| OpenError::Connect { address: to.to_string(), source };
        link.socket.connect(to).map_err(failed)?;
        link.local = link.socket.local_addr().map_err(failed)?;
        Ok(link)
    }

    fn bind(own: SocketAddr, role: Role) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Bind { address: own.to_string(), source };
        let socket = UdpSocket::bind(own).map_err(failed)?;
        socket.set_nonblocking(true).map_err(failed)?;
        let local = socket.local_addr().map_err(failed)?;
        Ok(Self { socket, local, role })
    }

    pub(super) fn recv(&self, buffer: &mut [u8]) -> io::Result<Received> {
        match self.socket.recv_from(buffer) {
            Ok((len, from)) => Ok(Received::Bytes { len, peer: Peer(Some(from)) }),
            Err(error) if is_nothing(&error) => Ok(Received::Nothing),
            Err(error) => Err(error),
        }
    }

    pub(super) fn confirm(&mut self, confirmed: Peer) {
        if let (Role::Listens { peer }, Some(_)) = (&mut self.role, confirmed.0) {
            *peer = confirmed.0;
        }
    }

    pub(super) fn send(&self, bytes: &[u8]) -> io::Result<Sent> {
        let sent = match self.role {
            Role::Listens { peer: None } => return Ok(Sent::NoPeer),
            Role::Listens { peer: Some(peer) } => self.socket.send_to(bytes, peer),
            Role::Sends { .. } => self.socket.send(bytes),
        };
        match sent {
            Ok(_) => Ok(Sent::Yes),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(Sent::Full),
            Err(error) if is_nothing(&error) => Ok(Sent::NoPeer),
            Err(error) => Err(error),
        }
    }

    pub(super) fn watch(&self) -> Watch<'_> {
        Watch { fd: self.socket.as_fd(), writes: false }
    }

    pub(super) const fn listens_on(&self) -> Option<SocketAddr> {
        match self.role {
            Role::Listens { .. } => Some(self.local),
            Role::Sends { .. } => None,
        }
    }

    pub(super) fn describe(&self) -> String {
        match self.role {
            Role::Listens { peer: None } => format!("listening on udp {}", self.local),
            Role::Listens { peer: Some(peer) } => format!("listening on udp {}, answering {peer}", self.local),
            Role::Sends { to } => format!("talking to udp {to} from {}", self.local),
        }
    }

    pub(super) fn advice(&self) -> String {
        match self.role {
            Role::Listens { .. } => format!(
                "the autopilot must send to port {port} of this computer (`--out` of ArduPilot's sim_vehicle.py, \
                 `mavlink start -o {port}` on PX4); a firewall may drop it; another program may have taken the port",
                port = self.local.port(),
            ),
            Role::Sends { to } => format!("somebody must listen on udp {to} and answer to the port it was asked from"),
        }
    }
}

/// Whether an error only means that there is nothing to receive: no datagram, or no program at the
/// other end's port just now (a simulator that is being restarted).
fn is_nothing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::ConnectionRefused | ErrorKind::Interrupted)
}
