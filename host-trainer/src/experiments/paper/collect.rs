//! From run folders to results.

use super::design::{SIZES, WORLDS};
use super::error::CollectError;
use super::kind::{Kind, common};
use super::results::{Baseline, Curves, Flight, Group, Results, RunResult, rounded};
use super::runs::{Run, check, finished, run_name, runs};
use crate::eval::{AnyActor, EvalConfig, EvalPolicy, ReferencePolicy, with_actor};
use crate::run::RunFolder;
use crate::settings::{Settings, word_of};
use crate::train::RoundMetrics;
use covey_env::{EpisodeMetrics, Scenario, ScenarioError};
use covey_report::{atomic, metrics};
use firmware_core::actor::Mode;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Hand-written policies to compare with.
pub const BASELINES: [ReferencePolicy; 4] =
    [ReferencePolicy::Random, ReferencePolicy::Centroid, ReferencePolicy::Planner, ReferencePolicy::Remembering];

/// Held-out worlds for the flights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Worlds {
    /// How many for each number of UAVs.
    pub count: u32,
    /// Their seed.
    pub seed: u64,
}

/// A run's flights with other numbers of UAVs, in its folder.
const FLIGHTS: &str = "flights.json";

/// What that file holds.
#[derive(Serialize, Deserialize)]
struct FlightsFile {
    /// Content hash of the actor that flew.
    actor: String,
    worlds: Worlds,
    flights: Vec<Flight>,
}

/// All finished runs below `out`, their actors flown with every number of UAVs in the first
/// `count` held-out worlds (none: as many as were flown before). What was flown before in the same
/// worlds is not flown again. `watch` hears of each policy that is flown.
///
/// # Errors
/// See [`CollectError`].
pub fn collect(out: &Path, count: Option<u32>, mut watch: impl FnMut(&str)) -> Result<Results, CollectError> {
    let count = count.unwrap_or_else(|| flown_before(out));
    let mut groups = Vec::new();
    let mut world: Option<Settings> = None;
    for kind in Kind::ALL {
        let runs: Vec<Run> = runs(out, kind)?.into_iter().filter(|r| finished(&r.folder)).collect();
        let Some(first) = runs.first() else { continue };
        check(&runs, &first.settings)?;
        same_worlds(first, world.get_or_insert_with(|| first.settings.clone()))?;
        let worlds = Worlds { count, seed: first.settings.eval_seed };
        let results = runs.iter().map(|run| {
            let name = format!("{} {}", kind.name(), run_name(&run.settings));
            Ok(RunResult {
                graph: word_of(run.settings.graph).to_owned(),
                seed: run.settings.seed,
                curves: curves(&run.folder)?,
                flights: flights(run, worlds, || watch(&name))?,
            })
        });
        let results = results.collect::<Result<Vec<_>, CollectError>>()?;
        groups.push(Group { kind, settings: common(&first.settings), runs: results });
    }
    let seed = world.as_ref().map_or(0, |s| s.eval_seed);
    let baselines = match &world {
        Some(s) => baselines(out, s, Worlds { count, seed }, watch)?,
        None => Vec::new(),
    };
    Ok(Results::new(SIZES.to_vec(), count, seed, groups, baselines))
}

/// Worlds that the runs below `out` flew in, the paper's number if none did.
fn flown_before(out: &Path) -> u32 {
    let runs = Kind::ALL.into_iter().flat_map(|kind| runs(out, kind).unwrap_or_default());
    let counts = runs.filter_map(|r| read(&r.folder.path().join(FLIGHTS))).map(|f| f.worlds.count);
    counts.max().unwrap_or(WORLDS)
}

/// Both groups fly the same worlds, but for the number of UAVs.
fn same_worlds(run: &Run, other: &Settings) -> Result<(), CollectError> {
    let (s, o) = (run.settings.world(), other.world());
    let pairs = [
        ("pois", s.pois.to_string(), o.pois.to_string()),
        ("poi_distribution", word_of(s.distribution).to_owned(), word_of(o.distribution).to_owned()),
        ("side", s.side_u.to_string(), o.side_u.to_string()),
        ("steps", s.steps.to_string(), o.steps.to_string()),
        ("eval_seed", run.settings.eval_seed.to_string(), other.eval_seed.to_string()),
    ];
    match pairs.into_iter().find(|(_, found, wanted)| found != wanted) {
        Some((key, found, wanted)) => {
            Err(CollectError::OtherWorlds { path: run.folder.path().to_owned(), key, found, wanted })
        }
        None => Ok(()),
    }
}

fn curves(folder: &RunFolder) -> Result<Curves, CollectError> {
    let rows: Vec<RoundMetrics> = metrics::read(folder.metrics())?;
    let list = |f: fn(&RoundMetrics) -> f64| rows.iter().map(|r| rounded(f(r))).collect::<Vec<_>>();
    let found = Curves {
        episodes: rows.iter().map(|r| r.episodes).collect(),
        reward: list(|r| r.reward),
        coverage: list(|r| r.coverage),
        energy: list(|r| r.energy),
        policy_loss: list(|r| r.policy_loss),
        individual: list(|r| r.individual),
        group: list(|r| r.group),
    };
    let all = [&found.reward, &found.coverage, &found.energy, &found.policy_loss, &found.individual, &found.group];
    match (0..rows.len()).find(|&k| all.iter().any(|list| !list[k].is_finite())) {
        Some(row) => Err(CollectError::NotFinite { path: folder.metrics(), row: row + 1 }),
        None => Ok(found),
    }
}

/// Flights of a run's int8 actor.
fn flights(run: &Run, worlds: Worlds, watch: impl FnOnce()) -> Result<Vec<Flight>, CollectError> {
    let (file, flown) = (run.folder.actor(), run.folder.path().join(FLIGHTS));
    let bad = |why: String| CollectError::Actor { path: file.clone(), why };
    let bytes = std::fs::read(&file).map_err(|e| bad(e.to_string()))?;
    let actor = AnyActor::load(&bytes).map_err(|e| bad(e.to_string()))?;
    let hash = format!("{:016x}", with_actor!(actor, actor => actor.content_hash()));
    cached(&flown, &hash, worlds, || {
        watch();
        fly(&EvalPolicy::of(&actor), &run.settings, worlds)
    })
}

/// Hand-written policies in the worlds of these settings, kept beside the run folders.
fn baselines(
    out: &Path,
    s: &Settings,
    worlds: Worlds,
    mut watch: impl FnMut(&str),
) -> Result<Vec<Baseline>, CollectError> {
    let w = s.world();
    let of = format!("{} {:?} {} {}", w.pois, w.distribution, w.side_u, w.steps);
    let fly = |policy: ReferencePolicy| {
        let file = out.join("runs").join(format!("{}.json", policy.name()));
        let flights = cached(&file, &of, worlds, || {
            watch(policy.name());
            fly(&EvalPolicy::Reference(policy), s, worlds)
        })?;
        Ok(Baseline { policy: policy.name().to_owned(), flights })
    };
    BASELINES.into_iter().map(fly).collect()
}

/// Flights that are in `file`, when those are of the same worlds and the same policy; else
/// new ones, which are put there.
fn cached(
    file: &Path,
    of: &str,
    worlds: Worlds,
    fly: impl FnOnce() -> Result<Vec<Flight>, ScenarioError>,
) -> Result<Vec<Flight>, CollectError> {
    let sizes = |flights: &[Flight]| flights.iter().map(|f| f.uavs).eq(SIZES);
    if let Some(flown) = read(file).filter(|f| f.actor == of && f.worlds == worlds && sizes(&f.flights)) {
        return Ok(flown.flights);
    }
    let flown = FlightsFile { actor: of.to_owned(), worlds, flights: fly()? };
    atomic::write(file, serde_json::to_string(&flown)?.as_bytes())?;
    Ok(flown.flights)
}

/// Flights that were written before; none when there are none, or none that can be read.
fn read(file: &Path) -> Option<FlightsFile> {
    std::fs::read(file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok())
}

fn fly(policy: &EvalPolicy<'_>, s: &Settings, worlds: Worlds) -> Result<Vec<Flight>, ScenarioError> {
    let one = |uavs: u16| {
        let scenario = Scenario { uavs: usize::from(uavs), ..s.world() };
        let config = EvalConfig { scenario, seed: worlds.seed, worlds: worlds.count, mode: Mode::Sample };
        let r = policy.evaluate("", &config)?;
        let values = [r.coverage, r.coverage_last, r.energy, r.individual, r.group, r.reward, r.fairness];
        Ok(Flight { uavs, mean: EpisodeMetrics::from_values(values.map(rounded)) })
    };
    SIZES.into_iter().map(one).collect()
}
