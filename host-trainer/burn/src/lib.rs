//! The trainer's networks in burn, behind [`covey_net::Engine`]: `BurnEngine`.
//!
//! Everything is a dense product over whole minibatches, as GPUs like it, where the networks by
//! hand skip zeros and stay in a core's cache. burn's autodiff computes the gradients, so these
//! networks are the reference for those by hand, too.
//!
//! The crate is empty unless one of its features is on: `cuda` and `wgpu` for GPUs, `flex`
//! (burn's own CPU device) for tests.
#![forbid(unsafe_code)]
#![cfg(any(feature = "cuda", feature = "wgpu", feature = "flex"))]

mod device;
mod engine;
mod networks;
mod packed;

pub use device::{Kind, NoDevice};
pub use engine::BurnEngine;
