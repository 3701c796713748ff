//! `cargo xtask test`: runs every check and test and prints a summary at the end.

mod step;
mod tally;

use std::time::{Duration, Instant};

use crate::error::{Error, Result};
use crate::output::{print, show};
use crate::setup::{self, Item};
use step::{STEPS, Step};
use tally::Tally;

/// Options of `cargo xtask test`.
#[derive(clap::Args)]
pub struct Args {
    /// Run only this step; may be given more than once.
    #[arg(long, value_name = "STEP")]
    only: Vec<String>,
    /// List the steps and their commands.
    #[arg(long)]
    list: bool,
}

/// The result of a step.
struct Outcome {
    name: &'static str,
    /// How long the step took.
    took: Duration,
    /// Why the step failed, if it did.
    error: Option<Error>,
}

/// Runs the steps one after the other; the later ones run even if one fails.
///
/// # Errors
/// A step on the command line is unknown, or at least one step failed.
pub fn main(args: &Args) -> Result<()> {
    let steps = select(&args.only)?;
    if args.list {
        let lines: String = steps.iter().map(|step| format!("{:<12} {}\n", step.name, step.command())).collect();
        return print(&lines);
    }

    let mut needs: Vec<Item> = Vec::new();
    for need in steps.iter().flat_map(|step| step.needs) {
        if !needs.contains(need) {
            needs.push(*need);
        }
    }
    let mut tally = Tally::default();
    let mut outcomes = Vec::new();
    if !needs.is_empty() {
        outcomes.push(timed("setup", || setup::install(&needs)));
    }
    for step in steps {
        show!("\n== {}: {}", step.name, step.command());
        outcomes.push(timed(step.name, || step.run(&mut tally)));
    }
    summarise(&outcomes, &tally)
}

/// The steps of these names; all where there are none.
fn select(only: &[String]) -> Result<Vec<&'static Step>> {
    if let Some(name) = only.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        let known: Vec<_> = STEPS.iter().map(|step| step.name).collect();
        return Err(Error::Unknown { kind: "step", name: name.clone(), known: known.join(", ") });
    }
    Ok(STEPS.iter().filter(|step| only.is_empty() || only.iter().any(|name| name == step.name)).collect())
}

/// Runs `action`, prints its error if it fails, and measures its time.
fn timed(name: &'static str, action: impl FnOnce() -> Result<()>) -> Outcome {
    let start = Instant::now();
    let error = action().err();
    if let Some(error) = &error {
        show!("{name}: {error}");
    }
    Outcome { name, took: start.elapsed(), error }
}

/// Prints a line for each step, then the errors, and the count of tests as the last line.
fn summarise(outcomes: &[Outcome], tally: &Tally) -> Result<()> {
    show!("\n== summary");
    for outcome in outcomes {
        let word = if outcome.error.is_some() { "FAILED" } else { "ok" };
        show!("{:<12} {word:<6} {:>5} s", outcome.name, outcome.took.as_secs());
    }
    let failed: Vec<_> = outcomes.iter().filter_map(|outcome| Some((outcome.name, outcome.error.as_ref()?))).collect();
    for (name, error) in &failed {
        let again = if *name == "setup" { "setup".to_owned() } else { format!("test --only {name}") };
        show!("{name}: {error}\n  again alone: cargo xtask {again}");
    }
    show!("{}", tally.closing_line(failed.len()));
    if failed.is_empty() { Ok(()) } else { Err(Error::Reported) }
}
