//! What receiving and sending on a link return.

use std::io;
use std::net::SocketAddr;

/// A receive buffer of this length holds every datagram that a MAVLink sender makes, bytes.
pub const RECEIVE_LEN: usize = 2048;

/// The sender of received bytes: a UDP address, or the one other end of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer(pub(super) Option<SocketAddr>);

/// What [`super::Connection::recv`] found.
#[derive(Debug)]
pub enum Received {
    /// No bytes have arrived.
    Nothing,
    /// This many bytes are in the buffer: a datagram, or a piece of the stream.
    Bytes {
        /// Number of bytes.
        len: usize,
        /// Their sender.
        peer: Peer,
    },
    /// The stream is connected (again). The caller drops a frame whose end was lost: see
    /// [`crate::frame::Reader::reset`].
    Connected,
    /// The stream broke, for this reason; it reconnects by itself.
    Lost(io::Error),
}

/// What became of bytes to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sent {
    /// They were handed to the system.
    Yes,
    /// There is no peer: none was confirmed yet, or the stream is broken.
    NoPeer,
    /// The transmit buffer is full. The bytes were dropped: by the time it has room they would be stale.
    Full,
}
