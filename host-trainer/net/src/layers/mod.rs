//! The layers that networks are made of.

mod block_gradient;
mod dense;
mod encoder;
mod input_layer;

pub(crate) use block_gradient::BlockGradient;
pub(crate) use dense::{Bias, Dense, Weights};
pub(crate) use encoder::{Encoder, EncoderGradient, EncoderPass};
