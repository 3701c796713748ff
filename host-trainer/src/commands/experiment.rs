//! `experiment`: measurements that make a page for the documents.

use super::inspect::load;
use super::{read_actor, use_threads};
use crate::cli::{Experiment, ExperimentLink};
use crate::experiments::link::study;
use crate::measure::{EvalRow, Trial};
use crate::with_actor;
use covey_env::Scenario;
use covey_report::atomic;
use firmware_core::actor::Mode;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::time::Instant;

/// Runs one.
///
/// # Errors
/// When it cannot be measured or its files not be written.
pub fn run(experiment: &Experiment) -> Result<()> {
    match experiment {
        Experiment::Link(args) => link(args),
        Experiment::Paper(args) => super::paper::run(args),
    }
}

const PAGE: &str = "link-loss.md";
const PICTURE: &str = "link-loss.svg";

fn link(args: &ExperimentLink) -> Result<()> {
    use_threads(args.threads);
    if args.worlds < 2 {
        return Err(miette!("--worlds {}: a standard error needs at least 2 worlds", args.worlds));
    }
    let (bytes, name) = read_actor(args.model.as_deref())?;
    let actor = load(&bytes).wrap_err_with(|| format!("{name} cannot fly"))?;
    let scenario = Scenario { uavs: usize::from(args.uavs), distribution: args.scenario.into(), ..Scenario::default() };
    let trial = Trial { scenario, seed: args.seed, worlds: args.worlds, mode: Mode::Sample };
    std::fs::create_dir_all(&args.out).map_err(|e| miette!("cannot make the folder {}: {e}", args.out.display()))?;
    let start = Instant::now();
    let tell = |row: &EvalRow, k, all| {
        let link = row.link.as_ref().map_or("", |l| &l.link);
        eprintln!("{k} of {all}: {link}: coverage {:.4} ±{:.4}", row.coverage, row.coverage_se);
    };
    let study = with_actor!(actor, actor => study(actor, &trial, tell)).into_diagnostic()?;
    for (file, text) in [(PAGE, study.page(PICTURE, &command(args))), (PICTURE, study.picture().into_diagnostic()?)] {
        let path = args.out.join(file);
        atomic::write(&path, text.as_bytes()).into_diagnostic()?;
        eprintln!("wrote {}", path.display());
    }
    eprintln!("{:.0} s on {} threads", start.elapsed().as_secs_f64(), rayon::current_num_threads());
    if args.json {
        println!("{}", serde_json::to_string_pretty(&study.rows()).into_diagnostic()?);
    }
    Ok(())
}

/// What has to be typed to get the same page.
fn command(args: &ExperimentLink) -> String {
    let mut command = String::from("host-trainer experiment link");
    let defaults = ExperimentLink::default();
    let distribution = |l| covey_env::PoiDistribution::from(l);
    if let Some(model) = &args.model {
        command += &format!(" --model {}", model.display());
    }
    if args.uavs != defaults.uavs {
        command += &format!(" --uavs {}", args.uavs);
    }
    if args.scenario != defaults.scenario {
        command += &format!(" --scenario {}", crate::settings::distribution_name(distribution(args.scenario)));
    }
    if args.worlds != defaults.worlds {
        command += &format!(" --worlds {}", args.worlds);
    }
    if args.seed != defaults.seed {
        command += &format!(" --seed {}", args.seed);
    }
    command
}
