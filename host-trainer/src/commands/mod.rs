//! What the commands do.

mod against;
mod bench;
mod boards;
mod device;
mod eval;
mod experiment;
mod export;
mod inspect;
mod machine;
mod paper;
mod report;
mod train;

use crate::cli::{Command, DistributionArg, GraphArg};
use crate::settings::{KEYS, Settings};
use covey_env::PoiDistribution;
use firmware_core::actor::Aggregation;
use miette::{IntoDiagnostic, Result};
use std::path::Path;

pub use inspect::load as load_actor;

/// Runs a command.
///
/// # Errors
/// What went wrong and what to do about it.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Train(a) => train::run(a),
        Command::Eval(a) => eval::run(a),
        Command::Experiment(e) => experiment::run(e),
        Command::Export(a) => export::run(a),
        Command::Inspect(a) => inspect::run(a),
        Command::Report(a) => report::run(a),
        Command::Bench(a) => bench::run(a),
        Command::Settings => {
            print!("{}", settings_page());
            Ok(())
        }
    }
}

fn settings_page() -> String {
    let mut out = String::from("# Settings of a training run with their defaults. Use with train --config.\n\n");
    for key in KEYS {
        for line in key.doc {
            out += &format!("#{line}\n");
        }
        out += &format!("# {}\n{} = {}\n\n", key.allowed, key.name, (key.default)());
    }
    out
}

impl From<GraphArg> for Aggregation {
    fn from(g: GraphArg) -> Self {
        match g {
            GraphArg::None => Self::None,
            GraphArg::Gcn => Self::Gcn,
            GraphArg::Gat => Self::Gat,
        }
    }
}

impl From<DistributionArg> for PoiDistribution {
    fn from(l: DistributionArg) -> Self {
        match l {
            DistributionArg::Clustered => Self::Clustered,
            DistributionArg::Uniform => Self::Uniform,
        }
    }
}

/// Threads of the machine.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Sets the threads that evaluations use. A second call changes nothing.
fn use_threads(threads: Option<usize>) {
    // Fails only when the pool is there already, which is as good.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build_global();
}

/// Applies `--set` to settings and checks them.
fn apply(settings: &mut Settings, assignments: &[String]) -> Result<()> {
    assignments.iter().try_for_each(|a| settings.set(a)).into_diagnostic()?;
    settings.check().into_diagnostic()
}

/// The actor of a `--model`, and what to call it.
fn read_actor(model: Option<&Path>) -> Result<(Vec<u8>, String)> {
    covey_env::open_actor(model).map_err(|e| unreadable(model.unwrap_or_else(|| Path::new("gcn")), &e))
}

/// A file's bytes.
fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| unreadable(path, &e))
}

fn unreadable(path: &Path, e: &std::io::Error) -> miette::Report {
    miette::miette!("cannot read {}: {e}", path.display())
}
