#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod autopilot;
pub mod commands;
pub mod connection;
pub mod frame;
pub mod messages;
pub mod mission;
pub mod node;
pub mod outlet;
pub mod replay;
pub mod signing;
pub mod simulation;
pub mod status_view;
pub mod swarm_link;
pub mod tlog;
