//! `eval --actor qemu-…`: the flight program in QEMU decides.

use crate::cli::Processor;
use crate::commands::interrupt::Stop;
use crate::commands::output::tell;
use crate::eval::pil::{Difference, PilEpisode, fly_episode};
use crate::eval::{EvalConfig, EvalRow, PilFigures};
use crate::settings::word_of;
use covey_env::{Evaluation, World};
use covey_pil::Options;
use covey_pil::qemu::{Machine, Qemu};
use firmware_core::actor::Actor;
use miette::{IntoDiagnostic, Result, miette};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Where `cargo xtask targets` puts the flight program, in cargo's target folder.
const IMAGE: &str = "targets/mps2/thumbv7em-none-eabihf/release/flight";
/// What a request may take on a busy computer.
const PATIENCE: Options = Options { timeout: Duration::from_secs(30), attempts: 2 };

/// An emulated board and its flight program.
pub struct Emulated {
    machine: Machine,
    name: &'static str,
    image: PathBuf,
}

impl Emulated {
    /// The board of `--actor` and the program of `--image`; none when this computer decides.
    ///
    /// # Errors
    /// There is no program.
    pub fn find(actor: Processor, image: Option<&Path>) -> Result<Option<Self>> {
        let (machine, name) = match actor {
            Processor::Host => return Ok(None),
            Processor::QemuM7 => (Machine::CortexM7, "qemu-m7"),
            Processor::QemuM4f => (Machine::CortexM4f, "qemu-m4f"),
        };
        let places = image.map_or_else(usual_places, |image| vec![image.to_owned()]);
        match places.iter().find(|place| place.is_file()) {
            Some(image) => Ok(Some(Self { machine, name, image: image.clone() })),
            None => {
                let places: Vec<_> = places.iter().map(|place| place.display().to_string()).collect();
                Err(miette!(
                    help = "`cargo xtask targets` builds it; --image names one elsewhere",
                    "no flight program at {}",
                    places.join(" or ")
                ))
            }
        }
    }

    /// Flies the worlds of `config` with `actor`, whose file is given; `policy` goes into the row.
    /// Also returns the first decision that differs. A signal ends it, and the program.
    ///
    /// # Errors
    /// A board does not start or answer, or the scenario cannot be built.
    pub fn evaluate(
        &self,
        policy: &str,
        file: &[u8],
        actor: &Actor<'_>,
        config: &EvalConfig,
        stop: &Stop,
    ) -> Result<(EvalRow, Option<Difference>)> {
        let flown = {
            // The boards are processes of their own, and have to be ended.
            let _waits = stop.waits("stopping the emulated boards at the end of their worlds, which can take a minute");
            self.fly(file, actor, config, stop)
        };
        stop.end_if_signalled();
        let flown = flown?;
        let (mut decisions, mut differences, mut first) = (0, 0, None);
        for world in &flown {
            decisions += world.decisions;
            differences += world.differences;
            first = first.or(world.first);
        }
        let evaluation = Evaluation { worlds: flown.iter().map(|world| world.metrics).collect() };
        let mut row = EvalRow::new(policy, config, word_of(config.mode), &evaluation);
        row.board = Some(PilFigures { actor: self.name.to_owned(), decisions, differences });
        Ok((row, first))
    }

    /// Each board takes the next world when it is done with one.
    fn fly(&self, file: &[u8], actor: &Actor<'_>, config: &EvalConfig, stop: &Stop) -> Result<Vec<PilEpisode>> {
        let fresh = World::new(&config.scenario).into_diagnostic()?;
        let worlds = u64::from(config.worlds);
        let boards = (rayon::current_num_threads() as u64).min(worlds);
        let next = AtomicU64::new(0);
        let progress = Progress::new(self.name, worlds);
        let work = || -> Result<Vec<(u64, PilEpisode)>> {
            let qemu = Qemu::start(self.machine, &self.image, Some(file)).into_diagnostic()?;
            let mut board = qemu.client(PATIENCE).into_diagnostic()?;
            let mut world = fresh.clone();
            let mut flown = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= worlds || stop.asked() {
                    return Ok(flown);
                }
                let result = fly_episode(&mut board, actor, config, &mut world, index).into_diagnostic();
                if result.is_err() {
                    // The other boards need not go on.
                    next.store(worlds, Ordering::Relaxed);
                }
                let result = result?;
                progress.add(&result);
                flown.push((index, result));
            }
        };
        let mut flown = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..boards).map(|_| scope.spawn(work)).collect();
            let mut all = Vec::new();
            for thread in threads {
                all.append(&mut thread.join().map_err(|_| miette!("a board's thread failed"))??);
            }
            Ok::<_, miette::Report>(all)
        })?;
        flown.sort_by_key(|(index, _)| *index);
        Ok(flown.into_iter().map(|(_, flown)| flown).collect())
    }
}

/// Beside this program, as cargo builds it, and in the target folder of this folder.
fn usual_places() -> Vec<PathBuf> {
    let program = std::env::current_exe().ok();
    let beside = program.as_deref().and_then(|p| p.parent()?.parent()).map(|target| target.join(IMAGE));
    let here = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from).join(IMAGE);
    beside.into_iter().chain([here]).collect()
}

/// Says how far the boards are, ten times in all.
struct Progress {
    name: &'static str,
    worlds: u64,
    start: Instant,
    done: Mutex<(u64, u64, u64)>,
}

impl Progress {
    fn new(name: &'static str, worlds: u64) -> Self {
        Self { name, worlds, start: Instant::now(), done: Mutex::new((0, 0, 0)) }
    }

    fn add(&self, flown: &PilEpisode) {
        // A thread that failed while it counted spoils no count.
        let mut done = self.done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (worlds, decisions, differences) = &mut *done;
        *worlds += 1;
        *decisions += flown.decisions;
        *differences += flown.differences;
        if *worlds * 10 / self.worlds > (*worlds - 1) * 10 / self.worlds {
            let rate = *decisions as f64 / self.start.elapsed().as_secs_f64();
            tell!(
                "{}: {worlds} of {} worlds, {decisions} decisions ({rate:.0} a second), {differences} differences",
                self.name,
                self.worlds
            );
        }
    }
}
