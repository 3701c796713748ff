//! Addresses of the swarm link, as users write them.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::str::FromStr;
use thiserror::Error;

/// The address of the swarm link, read from `multicast:239.86.67.1:14600`,
/// `multicast:239.86.67.1:14600@192.168.4.2`, `broadcast:192.168.4.255:14600` or
/// `peers:0.0.0.0:14600,192.168.4.3:14600,192.168.4.4:14600`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum SwarmAddress {
    /// A multicast group that all UAVs of the local network join.
    Multicast {
        /// The group and its port.
        group: SocketAddrV4,
        /// The own address on the network to use; the system chooses when it is 0.0.0.0.
        interface: Ipv4Addr,
    },
    /// The broadcast address of the local network.
    Broadcast {
        /// The network's broadcast address and the port.
        to: SocketAddrV4,
    },
    /// A list of peers, each by its address.
    Peers {
        /// Where this one listens.
        listen: SocketAddr,
        /// The others.
        peers: Vec<SocketAddr>,
    },
}

/// Why a swarm address is refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SwarmAddressError {
    /// It does not begin with a kind of swarm link.
    #[error("`{0}`: a swarm is reached by multicast, broadcast or peers, as in `multicast:239.86.67.1:14600`")]
    UnknownKind(String),
    /// An address or port cannot be read.
    #[error("`{0}` is no address with a port, as in `{1}`")]
    BadAddress(String, &'static str),
    /// The group is no multicast address.
    #[error("{0} is no multicast address: they go from 224.0.0.0 to 239.255.255.255, 239 is for private use")]
    NotMulticast(Ipv4Addr),
    /// The network interface's address cannot be read.
    #[error("`{0}` is no address of a network interface, as in `multicast:239.86.67.1:14600@192.168.4.2`")]
    BadInterface(String),
}

const MULTICAST: &str = "multicast:239.86.67.1:14600";
const BROADCAST: &str = "broadcast:192.168.4.255:14600";
const PEERS: &str = "peers:0.0.0.0:14600,192.168.4.3:14600";

impl FromStr for SwarmAddress {
    type Err = SwarmAddressError;

    fn from_str(text: &str) -> Result<Self, SwarmAddressError> {
        let Some((kind, rest)) = text.split_once(':') else { return Err(SwarmAddressError::UnknownKind(text.into())) };
        let rest = rest.strip_prefix("//").unwrap_or(rest);
        match kind.to_ascii_lowercase().as_str() {
            "multicast" => {
                let (group, interface) = rest.split_once('@').unwrap_or((rest, "0.0.0.0"));
                let group: SocketAddrV4 = with_port(group, MULTICAST)?;
                let interface = interface.parse().map_err(|_| SwarmAddressError::BadInterface(interface.into()))?;
                if !group.ip().is_multicast() {
                    return Err(SwarmAddressError::NotMulticast(*group.ip()));
                }
                Ok(Self::Multicast { group, interface })
            }
            "broadcast" => Ok(Self::Broadcast { to: with_port(rest, BROADCAST)? }),
            "peers" => {
                let mut addresses = rest.split(',').map(str::trim);
                let listen = addresses.next().unwrap_or_default();
                let listen = listen.parse().map_err(|_| SwarmAddressError::BadAddress(listen.into(), PEERS))?;
                let peers = addresses.map(|peer| with_port(peer, PEERS)).collect::<Result<_, _>>()?;
                Ok(Self::Peers { listen, peers })
            }
            _ => Err(SwarmAddressError::UnknownKind(kind.into())),
        }
    }
}

/// A string that reads back as the same address.
impl fmt::Display for SwarmAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Multicast { group, interface } if interface.is_unspecified() => write!(f, "multicast:{group}"),
            Self::Multicast { group, interface } => write!(f, "multicast:{group}@{interface}"),
            Self::Broadcast { to } => write!(f, "broadcast:{to}"),
            Self::Peers { listen, peers } => {
                write!(f, "peers:{listen}")?;
                peers.iter().try_for_each(|peer| write!(f, ",{peer}"))
            }
        }
    }
}

/// An address with a port that is not 0.
fn with_port<A: FromStr + Copy + Into<SocketAddr>>(text: &str, example: &'static str) -> Result<A, SwarmAddressError> {
    let read = text.parse::<A>().ok().filter(|&address| address.into().port() != 0);
    read.ok_or_else(|| SwarmAddressError::BadAddress(text.into(), example))
}
