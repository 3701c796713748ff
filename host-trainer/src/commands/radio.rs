//! `experiment radio`: coverage over radios that lose and delay messages.

use super::actor::{load, read_actor};
use super::threads::use_threads;
use crate::cli::ExperimentRadio;
use crate::commands::hold::Hold;
use crate::commands::interrupt::Stop;
use crate::commands::meter::Meter;
use crate::commands::output::{say_out, tell};
use crate::eval::{EvalConfig, EvalRow, Watch, with_actor};
use crate::experiments::radio::{study, study_agent_steps};
use crate::settings::word_of;
use covey_env::Scenario;
use covey_report::atomic;
use firmware_core::actor::Mode;
use miette::{IntoDiagnostic, Result, miette};
use std::time::Instant;

const PAGE: &str = "radio-loss.md";
const PICTURE: &str = "radio-loss.svg";

/// Measures and writes page and picture.
///
/// # Errors
/// When it cannot be measured or its files not be written.
pub fn run(args: &ExperimentRadio) -> Result<()> {
    if args.worlds < 2 {
        return Err(miette!("--worlds {}: a standard error needs at least 2 worlds", args.worlds));
    }
    let parting = format!("stopped measuring; nothing was written in {}", args.out.display());
    let stop = Stop::with_words(parting)?;
    use_threads(args.threads);
    let (bytes, name) = read_actor(args.model.as_deref())?;
    let actor = load(&bytes, &name)?;
    let scenario =
        Scenario { uavs: usize::from(args.uavs), distribution: args.poi_distribution, ..Scenario::default() };
    let config = EvalConfig { scenario, seed: args.seed, worlds: args.worlds, mode: Mode::Sample };
    std::fs::create_dir_all(&args.out).map_err(|e| miette!("cannot make the folder {}: {e}", args.out.display()))?;
    let start = Instant::now();
    Hold::before_measuring()?;
    let meter = Meter::new(false, study_agent_steps(&config));
    let say = |row: &EvalRow, k, all| {
        let radio = row.radio.as_ref().map_or("", |r| &r.radio);
        meter.say(&format!("{k} of {all}: {radio}: coverage {:.4} ±{:.4}", row.coverage, row.coverage_se));
    };
    let steps: Watch<'_> = &|agent_steps| meter.add(agent_steps);
    let study = with_actor!(actor, actor => study(actor, &config, steps, say)).into_diagnostic()?;
    drop(meter);
    stop.at_once(format!("stopped while writing in {}; every file there is whole", args.out.display()));
    for (file, text) in [(PAGE, study.page(PICTURE, &command(args))), (PICTURE, study.picture().into_diagnostic()?)] {
        let path = args.out.join(file);
        atomic::write(&path, text.as_bytes()).into_diagnostic()?;
        tell!("wrote {}", path.display());
    }
    tell!("{:.0} s on {} threads", start.elapsed().as_secs_f64(), rayon::current_num_threads());
    if args.json {
        say_out!("{}", serde_json::to_string_pretty(&study.rows()).into_diagnostic()?)?;
    }
    Ok(())
}

/// What has to be typed to get the same page.
fn command(args: &ExperimentRadio) -> String {
    let mut command = String::from("host-trainer experiment radio");
    let defaults = ExperimentRadio::default();
    if let Some(model) = &args.model {
        command += &format!(" --model {}", model.display());
    }
    if args.uavs != defaults.uavs {
        command += &format!(" --uavs {}", args.uavs);
    }
    if args.poi_distribution != defaults.poi_distribution {
        command += &format!(" --poi-distribution {}", word_of(args.poi_distribution));
    }
    if args.worlds != defaults.worlds {
        command += &format!(" --worlds {}", args.worlds);
    }
    if args.seed != defaults.seed {
        command += &format!(" --seed {}", args.seed);
    }
    command
}
