#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod actor;
mod actor_critic;
mod aggregation;
mod critic;
mod engine;
mod graph_layer;
mod init;
mod input;
pub mod kernel;
mod layers;
mod math;
mod matrix;
mod parameter_layout;

pub use actor::{ActorGradient, ActorNet, ActorPass};
pub use actor_critic::ActorCritic;
pub use critic::{CriticGradient, CriticNet, CriticPass};
pub use engine::{Engine, EngineError, GraphBatch, Outputs};
pub use init::initialise;
pub use input::{Inputs, micro_batch_size};
pub use math::{exp, ln};
pub use matrix::Rows;
pub use parameter_layout::{ParameterBlock, ParameterLayout};
