//! Trains Covey's policy, quantises it and measures it.

pub mod net;
pub mod settings;
pub mod train;
