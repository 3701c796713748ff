//! What a run leaves behind, for people and for tools.
//!
//! - [`atomic`]: whole files that are either old or new, never half;
//! - [`metrics`]: one JSON object a line, exact across an interruption;
//! - [`tensorboard`]: the same numbers as TensorBoard event files;
//! - [`progress`]: a bar on a terminal, plain lines elsewhere;
//! - [`report`]: curves, tables and episodes as one HTML page.
//!
//! The crate knows nothing of training or flight: callers hand it plain data.

#![forbid(unsafe_code)]

pub mod atomic;
pub mod metrics;
pub mod progress;
pub mod report;
pub mod tensorboard;
