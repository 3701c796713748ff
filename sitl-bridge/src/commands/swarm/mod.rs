//! `swarm`: several UAVs from one computer, over real links or, with `--sim`, against simulated
//! autopilots.

mod command;
mod real;
mod shared;
mod simulated;

pub(crate) use command::Swarm;
