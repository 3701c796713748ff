//! `swarm --sim`: against simulated autopilots.

use super::shared::SharedArgs;
use crate::commands::output::print;
use crate::outlet::say;
use crate::simulation::{FleetKind, Page, Simulation, WorldFlight, find_python};
use crate::status_view::ViewMode;
use covey_env::Scenario;
use firmware_core::actor::{Actor, Mode};
use miette::{IntoDiagnostic as _, Result, miette};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Arguments with `--sim`.
#[derive(clap::Args)]
pub(super) struct SimulatedArgs {
    /// The scenario's own dynamics: then every action is the trainer's.
    #[arg(long, requires = "sim")]
    ideal: bool,
    /// Simulated autopilots are PX4 instead of ArduPilot.
    #[arg(long, requires = "sim")]
    px4: bool,
    /// Worlds to fly, one after the other.
    #[arg(long, default_value_t = 1)]
    worlds: u64,
    /// Index of the first of them.
    #[arg(long, default_value_t = 0)]
    first_world: u64,
    /// Seed of the worlds.
    #[arg(long, default_value_t = 777)]
    seed: u64,
    /// Number of PoIs.
    #[arg(long, default_value_t = 120)]
    pois: usize,
    /// Steps in a world.
    #[arg(long, default_value_t = 100)]
    steps: u32,
    /// Run at so many times real time: simlink otherwise as fast as nodes and fleet can together, real firmware in
    /// real time.
    #[arg(long, requires = "sim")]
    speed: Option<f64>,
    /// Take the most likely action instead of drawing one.
    #[arg(long, requires = "sim")]
    argmax: bool,
    /// Python with the packages of the simulated autopilots.
    #[arg(long)]
    python: Option<PathBuf>,
    /// Page that plays the flights beside the trainer's of the same worlds, an HTML file.
    #[arg(long, value_name = "FILE", requires = "sim")]
    report: Option<PathBuf>,
    /// JSON object set over the fleet's configuration, such as '{"wind": [3, 0]}'.
    #[arg(long, requires = "sim", value_parser = object)]
    fleet: Option<serde_json::Map<String, serde_json::Value>>,
}

fn object(text: &str) -> Result<serde_json::Map<String, serde_json::Value>, String> {
    serde_json::from_str(text).map_err(|e| format!("no JSON object: {e}"))
}

impl SimulatedArgs {
    fn check(&self, autopilots: &FleetKind, shared: &SharedArgs) -> Result<()> {
        if self.speed.is_some_and(|speed| !(0.1..=1000.0).contains(&speed)) {
            return Err(miette!("--speed: use 0.1 to 1000"));
        }
        if autopilots.is_real()
            && let Some(option) = only_simlink(self, shared)
        {
            return Err(miette!("{option} is for simlink alone, not for --sim {}", autopilots.name()));
        }
        // Its SYSTEM_TIME is the host's clock, which runs at another speed then.
        if matches!(autopilots, FleetKind::Px4(_)) && self.speed.is_some_and(|speed| (speed - 1.0).abs() > 1e-9) {
            return Err(miette!("--speed: PX4 tells the host's time, so it flies at 1 times real time only"));
        }
        Ok(())
    }

    /// Flies the worlds until the last step, or until `stop` is set.
    ///
    /// # Errors
    /// The settings are refused, the simulation fails, or the page cannot be written.
    pub fn simulate(
        self,
        autopilots: FleetKind,
        shared: SharedArgs,
        actor: Actor<'_>,
        stop: &Arc<AtomicBool>,
    ) -> Result<()> {
        self.check(&autopilots, &shared)?;
        let scenario =
            Scenario { uavs: usize::from(shared.count), pois: self.pois, steps: self.steps, ..Scenario::default() };
        scenario.validate().into_diagnostic()?;
        let timing = shared.timing.timing(firmware_core::neighbour_table::DEFAULT_STEP_MS)?;
        let simulation = Simulation {
            seed: self.seed,
            mode: if self.argmax { Mode::Argmax } else { Mode::Sample },
            autopilots,
            ideal: self.ideal,
            px4: self.px4,
            speed: self.speed,
            timing,
            rate_hz: shared.timing.rate_hz(),
            python: find_python(self.python.as_deref()),
            signing: shared.signing.links()?,
            key_file: shared.signing.key_file().map(Into::into),
            fleet: self.fleet.unwrap_or_default(),
            tlogs: shared.tlog,
            view: ViewMode::detect(shared.verbose),
            verbose: shared.verbose,
            ..Simulation::new(actor, scenario)
        };
        let json = shared.json;
        let mut page = self.report.map(|path| (path, Page::default(), Ok(())));
        let summary =
            simulation.run(self.first_world..self.first_world.saturating_add(self.worlds), stop, |index, flight| {
                if let Some((_, page, made)) = page.as_mut().filter(|(.., made)| made.is_ok()) {
                    *made = page.add(&simulation, index, flight);
                }
                say(&line(index, flight));
                if let (Some(difference), true) = (&flight.first_difference, shared.verbose || self.ideal) {
                    say(&format!("  the first other decision: {difference}"));
                }
            });
        let summary = summary.into_diagnostic()?;
        if let Some((path, page, made)) = page {
            made.and_then(|()| page.write(&path, &simulation, &summary)).into_diagnostic()?;
            say(&format!("{} plays the flight{}", path.display(), if summary.worlds == 1 { "" } else { "s" }));
        }
        if json {
            print(&format!("{}\n", serde_json::to_string_pretty(&summary).into_diagnostic()?))
        } else {
            print(&format!("{summary}\n"))
        }
    }
}

/// Refuses what only simlink can do, where real firmware flies.
fn only_simlink(args: &SimulatedArgs, shared: &SharedArgs) -> Option<&'static str> {
    if args.ideal {
        Some("--ideal")
    } else if args.px4 {
        Some("--px4")
    } else if args.fleet.is_some() {
        Some("--fleet")
    } else if shared.signing.key_file().is_some() {
        Some("--key-file")
    } else {
        None
    }
}

/// One world in a line.
fn line(index: u64, flight: &WorldFlight) -> String {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    format!(
        "world {index}: coverage {:.4} (trainer {:.4}), {:.1}x real time, {} of {} decisions as the trainer's, {} late",
        mean(&flight.coverage),
        mean(&flight.trainer_coverage),
        flight.simulated_s / flight.wall_s.max(1e-9),
        flight.equal,
        flight.compared,
        flight.counters.late_decisions,
    )
}
