#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![cfg(any(feature = "cuda", feature = "wgpu", feature = "flex"))]

mod device;
mod engine;
mod networks;
mod packed;

pub use device::{Kind, NoDevice};
pub use engine::BurnEngine;
