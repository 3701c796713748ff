//! What networks take: observations and neighbours of a micro-batch.

mod inputs;
mod multi_hot;

pub(crate) use inputs::InputRows;
pub use inputs::{Inputs, micro_batch_size};
pub(crate) use multi_hot::{MultiHotRows, add_multi_hot_gradient, multi_hot_matmul};
