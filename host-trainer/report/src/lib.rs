#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod atomic;
mod io_advice;
pub mod metrics;
pub mod progress;
pub mod report;
mod sync;
pub mod tensorboard;
