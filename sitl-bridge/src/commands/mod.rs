//! The command line.

mod actor_file;
mod args;
mod command;
mod console;
mod fly;
mod mission;
mod output;
mod recorded;
mod recording;
mod replay;
mod swarm;

pub use command::Cli;
