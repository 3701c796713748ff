#![doc = include_str!("../README.md")]
#![deny(missing_docs)]
#![forbid(unsafe_code)]

mod answers;
mod client;
mod convert;
mod error;
mod exchange;
mod loopback;
#[cfg(unix)]
pub mod qemu;
mod uav_step;

pub use answers::{BoardReport, HearOutcome, Observed};
pub use client::Client;
pub use error::PilError;
pub use exchange::Options;
pub use loopback::Loopback;
pub use uav_step::UavStep;
