//! Trains Covey's policy, quantises it and measures it.

pub mod any_actor;
mod backend;
pub mod cli;
pub mod commands;
pub mod experiments;
pub mod finish;
pub mod float_actor;
pub mod in_the_loop;
pub mod measure;
mod optim;
pub mod over_link;
pub mod quantise;
pub mod report_page;
mod rollout;
pub mod run;
pub mod settings;
pub mod train;
