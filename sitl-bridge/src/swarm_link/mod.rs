//! The link between the UAVs of a swarm: neighbour messages inside MAVLink frames.
//!
//! Each message travels in a V2_EXTENSION (#248) of its own, broadcast to all, with the message type
//! [`MESSAGE_TYPE`]. The frame's system id is the sender's id plus one, and the id in the message
//! must agree with it. [`SwarmLink`] makes, authenticates and parses the frames; [`SwarmSocket`]
//! sends and receives the datagrams by multicast, broadcast or to a list of peers.

mod address;
mod endpoint;
mod extension;
mod socket;

pub use address::{SwarmAddress, SwarmAddressError};
pub use endpoint::{Neighbour, SwarmError, SwarmLink};
pub use extension::{COMPONENT, MAX_ID, MESSAGE_TYPE, is_neighbour, neighbour_message, system_of};
pub use socket::SwarmSocket;
