#![doc = include_str!("../README.md")]
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
pub mod memory;
pub mod message;
pub mod navigation;
pub mod neighbour_table;
pub mod observation;
pub mod pil;
pub mod random;
