//! The networks of the trainer in floats: shared actor, central critic, and the
//! gradients of both, written out by hand for CPUs.
//!
//! Parameters live in one flat vector a network ([`ParameterLayout`]), so that gradients of
//! several parts are summed, clipped and applied as plain slices and a checkpoint is the
//! vectors themselves. [`ActorNet`] and [`CriticNet`] hold them in the form in which
//! products read them; [`ActorPass`] and [`CriticPass`] are the activations of some
//! world-steps ([`Inputs`]) and, afterwards, their gradients.
//!
//! What makes it fast: observations are two thirds zeros and a ReLU leaves more, so one
//! kernel ([`kernel`]) skips zeros in all products, forward, backward and of weight
//! gradients; and everything that a pass touches stays in a core's second-level cache.
#![deny(unsafe_code)]

mod active;
mod actor;
mod critic;
mod dense;
mod encoder;
mod engine;
mod graph;
mod init;
mod inputs;
pub mod kernel;
mod math;
pub mod matrix;
mod parameter_layout;

pub use actor::{ActorGradient, ActorNet, ActorPass};
pub use critic::{CriticGradient, CriticNet, CriticPass};
pub use engine::{Engine, EngineError, GraphBatch, Outputs};
pub use init::initialise;
pub use inputs::{Inputs, worlds_in_pass};
pub use math::{exp, ln};
pub use matrix::Rows;
pub use parameter_layout::{ParameterBlock, ParameterLayout};
