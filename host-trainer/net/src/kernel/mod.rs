//! The one kernel under every product, and what chooses it for the processor.
//!
//! Products skip zeros: see [`Product`]. Rows with few zeros go together, zeros included: a
//! weight fetched once serves all of them. Adding a zero changes no sum, so this changes no
//! result.
//!
//! Terms are added in ascending order by fused multiply-adds, whatever the instruction set:
//! results are the same to the bit on every processor. Without AVX2 and FMA on x86 they are
//! slow, not different.
//!
//! Unsafe code is in this module alone.
#![allow(unsafe_code)]

mod aligned;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod lanes;
mod product;
mod run;
mod simd;

pub(crate) use aligned::Aligned;
pub(crate) use lanes::PANEL;
pub use lanes::{LANES, padded};
pub use product::{Epilogue, Init, Product};
pub(crate) use run::dequantise;
pub use simd::{Vectorised, multiply_adds, vectorised};
