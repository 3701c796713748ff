//! Looking up host names.

use super::error::OpenError;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs as _};

/// The addresses of a host, IPv4 first, as simulators and radios mostly use it.
pub(super) fn resolve(host: &str, port: u16) -> Result<Vec<SocketAddr>, OpenError> {
    let failed = |source| OpenError::Resolve { host: host.into(), source };
    let mut addresses: Vec<_> = (host, port).to_socket_addrs().map_err(failed)?.collect();
    addresses.sort_by_key(SocketAddr::is_ipv6);
    if addresses.is_empty() { Err(failed(io::ErrorKind::NotFound.into())) } else { Ok(addresses) }
}
