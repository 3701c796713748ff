//! Writes an actor of the default widths with pseudo-random weights: `sample_actor none|gcn|gat|gatv2|sage FILE`.
//!
//! It flies nowhere in particular, but costs what a trained one costs, and has a signature.

#[path = "../tests/common/mod.rs"]
mod common;

use firmware_core::action::ACTIONS;
use firmware_core::actor::{Aggregation, Dimensions};
use firmware_core::observation::LEN;
use std::process::ExitCode;
use std::{env, fs};

/// The widths that the trainer has as its defaults.
const DEFAULT: Dimensions =
    Dimensions { observation: LEN as u16, hidden: 128, feature: 64, head: 64, actions: ACTIONS as u16 };

fn main() -> ExitCode {
    let args: Vec<String> = env::args().skip(1).collect();
    let [kind, path] = args.as_slice() else {
        eprintln!("usage: sample_actor none|gcn|gat|gatv2|sage FILE");
        return ExitCode::FAILURE;
    };
    let Some(aggregation) = Aggregation::ALL.into_iter().find(|a| a.name() == kind) else {
        eprintln!("no aggregation is called {kind}; choose none, gcn, gat, gatv2 or sage");
        return ExitCode::FAILURE;
    };
    if let Err(error) = fs::write(path, common::actor_of(DEFAULT, aggregation, 1)) {
        eprintln!("{path}: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
