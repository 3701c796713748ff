//! The on-board half of Covey.
//!
//! Everything a UAV needs to decide lives here and nowhere else: the action
//! table, the observation, the neighbour table, the two neighbour messages, the
//! int8 actor and its sampler. The trainer's environment, the MAVLink node and
//! the flight-controller image all call this code, so they cannot drift apart.
//!
//! `no_std`, no heap, no panic path. From the measured state to the action all
//! arithmetic is integer, so the same input gives the same action on every
//! target.
#![no_std]
#![deny(missing_docs)]
// Allowed in one module only, the assembly of `kernel`.
#![deny(unsafe_code)]

pub mod action;
pub mod actor;
pub mod agent;
pub mod gate;
pub mod geometry;
pub mod hash;
pub mod kernel;
pub mod message;
pub mod navigation;
pub mod neighbour_table;
pub mod observation;
pub mod pil;
pub mod random;
