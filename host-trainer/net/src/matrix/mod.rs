//! Matrices as the kernel takes them, and the products of a layer.

mod panels;
mod products;
mod rows;
mod transpose;

pub(crate) use panels::Panels;
pub(crate) use products::{Activation, add_bias_gradient, add_weight_gradient, matmul};
pub use rows::Rows;
