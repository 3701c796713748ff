//! The byte link to an autopilot: UDP, TCP or a serial line, named by the strings that
//! MAVProxy, pymavlink, MAVSDK and QGroundControl users write.
//!
//! Nothing here blocks. A [`Connection`] that can break (TCP, a USB serial adapter) reconnects by
//! itself: each [`Connection::recv`] tries again once a second. Finding MAVLink frames in the bytes
//! is the job of [`crate::frame`]. The caller calls [`Connection::confirm`] with the [`Peer`] that
//! sent an authentic frame; a listening link answers only that peer.

mod address;
mod error;
mod link;
mod poll;
mod resolve;
mod stream;
mod transfer;
mod udp;

pub use address::{Address, AddressError};
pub use error::OpenError;
pub use link::Connection;
pub use poll::{Watch, wait};
pub use transfer::{Peer, RECEIVE_LEN, Received, Sent};
