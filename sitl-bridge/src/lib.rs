//! Flies Covey's actor over MAVLink.
//!
//! The wire, from the outside in: [`connection`] moves bytes, [`frame`] finds MAVLink frames
//! in them, [`signing`] decides whose frames count, [`swarm_link`] carries the neighbours'
//! messages inside frames, and [`tlog`] records them all. Only connections, sockets, the
//! state file of signatures and the recorder touch the system; the rest is handed bytes and
//! times, and says what to send.
#![forbid(unsafe_code)]

pub mod connection;
pub mod frame;
pub mod mission;
pub mod signing;
pub mod swarm_link;
pub mod tlog;
