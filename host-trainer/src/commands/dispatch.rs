//! From the parsed command line to the command.

use super::{bench, eval, export, inspect, paper, radio, report, settings, train};
use crate::cli::{Command, Experiment};
use crate::commands::output::print_out;
use miette::Result;

/// Runs a command to its end.
///
/// # Errors
/// What went wrong and what to do about it.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Train(args) => train::run(args),
        Command::Eval(args) => eval::run(args),
        Command::Experiment(Experiment::Radio(args)) => radio::run(args),
        Command::Experiment(Experiment::Paper(args)) => paper::run(args),
        Command::Export(args) => export::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Report(args) => report::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Settings => {
            print_out!("{}", settings::page())?;
            Ok(())
        }
    }
}
