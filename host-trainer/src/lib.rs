//! Trains Covey's policy, quantises it and measures it.

pub mod float_actor;
pub mod net;
pub mod quantise;
pub mod settings;
pub mod train;
pub mod cli;
pub mod run;
