//! What Covey's bare-metal programs share: the board and the place of the actor file.
//!
//! `flight` is the program that flies, `measure` the one that tests and measures on QEMU. A board is one file in
//! [`board`] and a memory map in `memory/`.
#![no_std]
#![deny(missing_docs)]

pub mod actor_file;
pub mod board;
#[cfg(feature = "mps2")]
pub mod measure;

use panic_never as _;
