//! `experiment paper`: trains what is missing, flies it, writes the report.

use super::train::{INTERRUPTED, Session, stop_on_signals};
use super::{apply, cores, use_threads};
use crate::cli::ExperimentPaper;
use crate::experiments::paper::collect::{Run, check, collect, finished, folder_of, run_name, runs};
use crate::experiments::paper::{QUICK, Results, WORLDS, figures, page};
use crate::run::{CheckpointError, FolderError, RunFolder};
use crate::settings::{Graph, Settings};
use crate::train::{Trainer, Workers};
use covey_report::atomic;
use covey_report::progress::{Mode, Progress, Status};
use covey_report::report::chart_svg;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Held-out worlds of `--quick`.
const QUICK_WORLDS: u32 = 3;

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
    if !args.report_only {
        let wanted = plan(args)?;
        let stop = stop_on_signals()?;
        if !train(args, &wanted, threads, &stop)? {
            eprintln!("stopped, and saved; the same command goes on");
            std::process::exit(INTERRUPTED);
        }
    }
    let results = results(args)?;
    write(&results, &args.out, args.quiet)
}

/// Settings of every run, seed by seed, so that a part of the runs is of use too.
fn plan(args: &ExperimentPaper) -> Result<Vec<Settings>> {
    let kind = args.settings;
    let mut base = kind.settings();
    let quick = QUICK.iter().filter(|_| args.quick).map(|s| (*s).to_owned());
    let episodes = args.episodes.map(|n| format!("episodes={n}"));
    let all: Vec<String> = quick.chain(args.set.iter().cloned()).chain(episodes).collect();
    if let Some(set) = all.iter().find(|s| ["graph", "seed"].contains(&s.split('=').next().unwrap_or("").trim())) {
        return Err(miette!("--set {set}: the experiment chooses it; use --graphs and --seeds"));
    }
    let seeds = match &args.seeds {
        Some(text) => seeds(text)?,
        None if args.quick => vec![10, 11],
        None => (10..15).collect(),
    };
    let graphs: Vec<_> = match &args.graphs[..] {
        [] => kind.graphs().to_vec(),
        some => some.iter().map(|&g| g.into()).collect(),
    };
    apply(&mut base, &all)?;
    let mut found = Vec::new();
    for &seed in &seeds {
        for &graph in &graphs {
            let settings = Settings { graph: Graph(graph), seed, ..base.clone() };
            settings.check().into_diagnostic()?;
            if found.contains(&settings) {
                return Err(miette!("{} is named twice", run_name(&settings)));
            }
            found.push(settings);
        }
    }
    Ok(found)
}

/// `10-14` or `1,2,5`, also mixed.
fn seeds(text: &str) -> Result<Vec<u64>> {
    let wrong = || miette!("--seeds {text}: write 10-14 or 1,2,5");
    let number = |t: &str| t.trim().parse::<u64>().ok().filter(|&s| i64::try_from(s).is_ok()).ok_or_else(wrong);
    let mut found = Vec::new();
    for part in text.split(',') {
        match part.split_once('-') {
            Some((first, last)) => {
                let (first, last) = (number(first)?, number(last)?);
                if first > last || last - first >= 1000 {
                    return Err(wrong());
                }
                found.extend(first..=last);
            }
            None => found.push(number(part)?),
        }
    }
    Ok(found)
}

/// Trains all runs that are not finished. False when it was stopped.
fn train(args: &ExperimentPaper, wanted: &[Settings], threads: usize, stop: &AtomicBool) -> Result<bool> {
    let folder = folder_of(&args.out, args.settings);
    let present = runs(&args.out, args.settings).into_diagnostic()?;
    if let Some(settings) = wanted.first() {
        check(&present, settings).into_diagnostic()?;
    }
    let missing: Vec<&Settings> =
        wanted.iter().filter(|s| !present.iter().any(|r| is(r, s) && finished(&r.folder))).collect();
    let jobs = args.jobs.unwrap_or(threads).clamp(1, missing.len().max(1));
    let resumed = missing.iter().filter_map(|s| present.iter().find(|r| is(r, s)));
    let watch = Watch::new(args.quiet, wanted, missing.len(), resumed.map(already).sum());
    watch.say(&format!(
        "{} of {} runs to train in {}, {jobs} at a time with {} threads each",
        missing.len(),
        wanted.len(),
        folder.display(),
        (threads / jobs).max(1)
    ));
    let queue = Mutex::new(missing.into_iter());
    let work = || -> Result<bool> {
        let workers = Workers::new((threads / jobs).max(1)).into_diagnostic()?;
        loop {
            let next = queue.lock().ok().and_then(|mut q| q.next());
            let Some(settings) = next else { return Ok(true) };
            let path = folder.join(run_name(settings));
            let ended = one(&path, settings, &workers, stop, &watch).wrap_err_with(|| path.display().to_string());
            if ended.is_err() {
                // The others save and stop too.
                stop.store(true, Ordering::SeqCst);
            }
            if !ended? {
                return Ok(false);
            }
        }
    };
    let ended: Vec<Result<bool>> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
        handles.into_iter().map(|h| h.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    watch.finish();
    ended.into_iter().try_fold(true, |all, one| Ok(all & one?))
}

fn is(run: &Run, settings: &Settings) -> bool {
    run.settings.graph == settings.graph && run.settings.seed == settings.seed
}

/// Episodes of a run that are in its newest checkpoint.
fn already(run: &Run) -> u64 {
    let rounds = run.folder.load().map_or(0, |(_, checkpoint)| u64::from(checkpoint.state.rounds));
    rounds * u64::from(run.settings.num_envs)
}

/// Trains one run to its end, from its newest checkpoint where it has one. False when stopped.
fn one(path: &Path, settings: &Settings, workers: &Workers, stop: &AtomicBool, watch: &Watch) -> Result<bool> {
    if stop.load(Ordering::SeqCst) {
        return Ok(false);
    }
    let loaded = match RunFolder::open(path) {
        Ok(folder) => match folder.load() {
            Ok((_, checkpoint)) => Some((folder, checkpoint)),
            // Cut off before its first checkpoint: nothing is lost.
            Err(FolderError::Checkpoint(CheckpointError::None(_))) => {
                std::fs::remove_dir_all(path).map_err(|e| miette!("cannot remove {}: {e}", path.display()))?;
                None
            }
            Err(e) => return Err(e).into_diagnostic(),
        },
        Err(_) => None,
    };
    let resumed = loaded.is_some();
    let (folder, trainer) = match loaded {
        Some((folder, checkpoint)) => (folder, Trainer::resume(settings.clone(), checkpoint.state).into_diagnostic()?),
        None => {
            let trainer = Trainer::new(settings.clone()).into_diagnostic()?;
            (RunFolder::create(Some(path), settings).into_diagnostic()?, trainer)
        }
    };
    let mut session = Session::open(folder, trainer, resumed, Mode::Quiet)?;
    let mut before = session.episodes();
    let done = session.train(workers, stop, |row| {
        watch.played(row.episodes - before);
        before = row.episodes;
    })?;
    if done {
        session.finish()?;
        watch.say(&format!("{} is done", run_name(settings)));
    }
    Ok(done)
}

/// Progress of all runs together.
struct Watch {
    /// And the episodes done, by earlier processes too.
    progress: Mutex<(Progress, u64)>,
    start: Instant,
    /// Episodes done by earlier processes.
    before: u64,
    /// Agent-steps of an episode.
    steps: u64,
    quiet: bool,
}

impl Watch {
    fn new(quiet: bool, wanted: &[Settings], missing: usize, before: u64) -> Self {
        let episodes = wanted.first().map_or(0, |s| u64::from(s.rounds()) * u64::from(s.num_envs));
        let steps = wanted.first().map_or(0, |s| u64::from(s.steps) * u64::from(s.uavs));
        let progress = Progress::new(Mode::detect(quiet), episodes * missing as u64).resumed_at(before);
        Self { progress: Mutex::new((progress, before)), start: Instant::now(), before, steps, quiet }
    }

    fn with(&self, change: impl FnOnce(&mut (Progress, u64))) {
        // Progress is only shown: another thread's panic ends the program anyway.
        if let Ok(mut shared) = self.progress.lock() {
            change(&mut shared);
        }
    }

    fn say(&self, message: &str) {
        if !self.quiet {
            self.with(|(progress, _)| progress.line(message));
        }
    }

    fn played(&self, episodes: u64) {
        let elapsed = self.start.elapsed();
        self.with(|(progress, done)| {
            *done += episodes;
            progress.update(&Status {
                episodes: *done,
                elapsed,
                agent_steps_per_s: ((*done - self.before) * self.steps) as f64 / elapsed.as_secs_f64(),
                coverage: None,
                reward: None,
            });
        });
    }

    fn finish(&self) {
        self.with(|(progress, _)| progress.finish());
    }
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
            eprintln!("flying {policy}");
        }
    };
    let found = collect(&args.out, args.worlds.or(usual), say).into_diagnostic()?;
    if found.groups.is_empty() { Results::read(&args.out.join(RESULTS)).into_diagnostic() } else { Ok(found) }
}

const RESULTS: &str = "results.json";
const PAGE: &str = "report.md";
const FIGURES: &str = "figures";

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
        println!("report      {}", out.join(PAGE).display());
        println!("figures     {}", folder.display());
        println!("numbers     {}", out.join(RESULTS).display());
    }
    Ok(())
}
