#![doc = include_str!("../README.md")]

mod backend;
pub mod cli;
pub mod commands;
pub mod eval;
pub mod experiments;
pub mod export;
pub mod float_actor;
mod optim;
mod rollout;
pub mod run;
pub mod settings;
pub mod train;
