//! Flies Covey's actor over MAVLink.
//!
//! The wire, from the outside in: [`connection`] moves bytes, [`frame`] finds MAVLink frames
//! in them, [`signing`] decides whose frames count, [`swarm_link`] carries the neighbours'
//! messages inside frames, and [`tlog`] records them all. Only connections, sockets, the
//! state file of signatures and the recorder touch the system; the rest is handed bytes and
//! times, and says what to send.
//!
//! A [`node`] flies one UAV by a [`mission`]: it owns all state of it and is driven by
//! datagrams and times alone. [`autopilot`] is its view of the vehicle. [`replay`] runs one
//! again from a recording.
#![forbid(unsafe_code)]

pub mod autopilot;
pub mod commands;
pub mod connection;
pub mod frame;
pub mod messages;
pub mod mission;
pub mod node;
pub mod replay;
pub mod signing;
pub mod simulation;
pub mod status_view;
pub mod swarm_link;
pub mod tlog;
