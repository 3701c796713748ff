//! The command from its flags to its files.

use super::plan::plan;
use super::training::train;
use crate::cli::ExperimentPaper;
use crate::commands::hold::Hold;
use crate::commands::interrupt::{INTERRUPTED, Stop};
use crate::commands::output::{say_out, tell};
use crate::commands::threads::{cores, use_threads};
use crate::experiments::paper::{Results, WORLDS, collect, figures, page};
use covey_report::atomic;
use covey_report::report::chart_svg;
use miette::{IntoDiagnostic, Result, miette};
use std::path::{Path, PathBuf};

/// Held-out worlds of `--quick`.
const QUICK_WORLDS: u32 = 3;
const RESULTS: &str = "results.json";
const PAGE: &str = "report.md";
const FIGURES: &str = "figures";
const MEASURING: &str = "stopped while measuring; what was flown so far is kept, the same command goes on";
const STOPPED: &str = "stopped, and saved; the same command goes on";

/// Trains, flies, reports.
///
/// # Errors
/// Settings that do not fit the runs that are there, a run that cannot go on, files that cannot
/// be written.
pub fn run(args: &ExperimentPaper) -> Result<()> {
    if [args.jobs, args.threads].contains(&Some(0)) {
        return Err(miette!("--jobs and --threads: use at least 1"));
    }
    if let Some(worlds @ 0..2) = args.worlds {
        return Err(miette!("--worlds {worlds}: use at least 2"));
    }
    let threads = args.threads.unwrap_or_else(cores);
    use_threads(Some(threads));
    std::fs::create_dir_all(&args.out).map_err(|e| miette!("cannot make the folder {}: {e}", args.out.display()))?;
    let stop = Stop::with_words(STOPPED.into())?;
    if !args.report_only {
        let wanted = plan(args)?;
        if !train(args, &wanted, threads, &stop)? {
            tell!("{STOPPED}");
            std::process::exit(INTERRUPTED);
        }
    }
    stop.at_once(MEASURING.into());
    stop.end_if_signalled();
    Hold::before_measuring()?;
    let results = results(args)?;
    write(&results, &args.out, args.quiet)
}

/// Results of the finished runs; without any, those of `results.json`.
fn results(args: &ExperimentPaper) -> Result<Results> {
    let usual = match (args.quick, args.report_only) {
        (true, _) => Some(QUICK_WORLDS),
        (_, true) => None,
        _ => Some(WORLDS),
    };
    let say = |policy: &str| {
        if !args.quiet {
            tell!("flying {policy}");
        }
    };
    let found = collect(&args.out, args.worlds.or(usual), say).into_diagnostic()?;
    if found.groups.is_empty() { Results::read(&args.out.join(RESULTS)).into_diagnostic() } else { Ok(found) }
}

/// Report, figures and numbers.
fn write(results: &Results, out: &Path, quiet: bool) -> Result<()> {
    let folder = out.join(FIGURES);
    std::fs::create_dir_all(&folder).map_err(|e| miette!("cannot make the folder {}: {e}", folder.display()))?;
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    for (name, chart) in figures(results) {
        files.push((folder.join(name), chart_svg(&chart).into_diagnostic()?));
    }
    files.push((out.join(RESULTS), results.to_json().into_diagnostic()?));
    files.push((out.join(PAGE), page(results)));
    for (path, text) in &files {
        atomic::write(path, text.as_bytes()).into_diagnostic()?;
    }
    if !quiet {
        say_out!("report      {}", out.join(PAGE).display())?;
        say_out!("figures     {}", folder.display())?;
        say_out!("numbers     {}", out.join(RESULTS).display())?;
    }
    Ok(())
}
