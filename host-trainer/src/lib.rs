#![doc = include_str!("../README.md")]

pub mod cli;
pub mod commands;
pub mod eval;
pub mod experiments;
pub mod export;
pub mod float_actor;
pub mod run;
pub mod settings;
pub mod train;
