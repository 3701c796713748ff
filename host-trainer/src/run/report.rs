//! The report of a run: its figures, curves, settings and an episode.

use super::folder::RunFolder;
use crate::eval::{AnyActor, EvalConfig, EvalRow, EvaluationFile, with_actor};
use crate::settings::{Settings, word_of};
use crate::train::RoundMetrics;
use covey_env::policy_seed;
use covey_env::{ActorPolicy, Trace};
use covey_report::report::{
    Better, Cell, Chart, Column, Content, Episode, Estimate, Figure, Frame, Group, Reference, Report, Row as TableRow,
    Run, Section, Series, Table, comparison, episode_svg,
};
use covey_report::{atomic, metrics};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U};
use miette::{IntoDiagnostic, Result, miette};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Points of a curve before it is averaged over stretches.
const BINS: usize = 200;

/// The step of the picture: UAVs have found their places.
const PICTURE_STEP: usize = 80;

/// Writes the report of a run into its folder, and once it has an actor a picture of it
/// flying.
///
/// # Errors
/// When a file of the run cannot be read or the page not be written.
pub fn write(folder: &RunFolder) -> Result<PathBuf> {
    let path = folder.report();
    page(folder)?.write(&path).into_diagnostic()?;
    if let Some(episode) = episode(folder, &folder.settings().into_diagnostic()?)? {
        let step = PICTURE_STEP.min(episode.steps());
        let picture = episode_svg(&episode, step).into_diagnostic()?;
        atomic::write(folder.picture(), picture.as_bytes()).into_diagnostic()?;
    }
    Ok(path)
}

/// The report of a run. Before training has finished it has curves and settings only.
///
/// # Errors
/// When a file of the run cannot be read.
pub fn page(folder: &RunFolder) -> Result<Report> {
    let data = Data::read(folder)?;
    let s = &data.settings;
    let mut sections = Vec::new();
    if let Some(evaluation) = &data.evaluation {
        let figures = figures(evaluation).into_iter().map(|(f, _)| f).collect();
        sections.push(section("Result", "The int8 actor, as it flies.", Content::Figures(figures)));
        sections.push(section("Policies side by side", "", Content::Table(table(evaluation, s))));
    }
    if let Some(episode) = episode(folder, s)? {
        let lead = "The int8 actor in the first held-out world. Space plays, arrow keys step.";
        sections.push(section("An episode", lead, Content::Episodes(vec![episode])));
    }
    let lead = "Training episodes, with sampled actions; one point a round.";
    sections.push(section("Learning curves", lead, Content::Charts(charts(&data, &folder.name()))));
    sections.push(section("Settings", "", Content::Configuration(configuration(s))));
    Ok(Report { title: format!("Covey: {}", folder.name()), subtitle: subtitle(&data), sections })
}

/// A report that compares runs.
///
/// # Errors
/// When a file of a run cannot be read.
pub fn compare(folders: &[RunFolder]) -> Result<Report> {
    let mut runs = Vec::new();
    for folder in folders {
        let data = Data::read(folder)?;
        runs.push(Run {
            name: folder.name(),
            figures: data.evaluation.as_ref().map(figures).unwrap_or_default(),
            configuration: configuration(&data.settings),
            charts: charts(&data, &folder.name()),
        });
    }
    Ok(comparison("Covey: runs side by side", format!("{} runs", runs.len()), &runs))
}

struct Data {
    settings: Settings,
    rows: Vec<RoundMetrics>,
    evaluation: Option<EvaluationFile>,
}

impl Data {
    fn read(folder: &RunFolder) -> Result<Self> {
        let unreadable = |e| miette!("{} cannot be read: {e}", folder.evaluation().display());
        let evaluation = written(&folder.evaluation())?;
        let evaluation = evaluation.map(|bytes| serde_json::from_slice(&bytes).map_err(unreadable)).transpose()?;
        Ok(Self {
            settings: folder.settings().into_diagnostic()?,
            rows: metrics::read(folder.metrics()).into_diagnostic()?,
            evaluation,
        })
    }
}

/// What is in a file that is written when training has finished; none before.
fn written(file: &Path) -> Result<Option<Vec<u8>>> {
    match std::fs::read(file) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(miette!("cannot read {}: {e}", file.display())),
    }
}

fn section(title: &str, lead: &str, content: Content) -> Section {
    Section { title: title.into(), lead: lead.into(), content }
}

fn subtitle(data: &Data) -> String {
    let s = &data.settings;
    let done = data.rows.last().map_or(0, |r| r.episodes);
    format!(
        "{} · {} UAVs, {} {} PoIs · {done} of {} episodes · seed {}",
        word_of(s.graph).to_uppercase(),
        s.uavs,
        s.pois,
        word_of(s.poi_distribution),
        s.rounds() * s.num_envs,
        s.seed
    )
}

fn estimate(mean: f64, error: f64, decimals: usize) -> Estimate {
    Estimate { mean, standard_error: Some(error), decimals }
}

/// Decimals, unit and better end of a metric in tables.
fn manner(metric: &str) -> (usize, Better) {
    match metric {
        "reward" => (0, Better::Higher),
        "energy" => (3, Better::Lower),
        "individual" | "group" => (2, Better::Neither),
        _ => (3, Better::Higher),
    }
}

fn figures(e: &EvaluationFile) -> Vec<(Figure, Better)> {
    let Some(int8) = e.rows.first() else { return Vec::new() };
    let figure = |label: &str, mean, error, decimals, note: String| Figure {
        label: label.into(),
        value: estimate(mean, error, decimals),
        unit: String::new(),
        note,
    };
    let note = format!("{} held-out worlds", int8.worlds);
    let agreement = Figure {
        label: "int8 agrees with float".into(),
        value: Estimate { mean: 100.0 * e.argmax_agreement, standard_error: None, decimals: 2 },
        unit: "%".into(),
        note: format!("{} decisions", e.decisions_compared),
    };
    vec![
        (figure("Coverage index", int8.coverage, int8.coverage_se, 3, note.clone()), Better::Higher),
        (figure("Coverage, last step", int8.coverage_last, int8.coverage_last_se, 3, note.clone()), Better::Higher),
        (figure("Episodic reward", int8.reward, int8.reward_se, 0, note.clone()), Better::Higher),
        (figure("Energy index", int8.energy, int8.energy_se, 3, note), Better::Lower),
        (agreement, Better::Higher),
    ]
}

fn table(e: &EvaluationFile, s: &Settings) -> Table {
    let names = e.rows.first().map(EvalRow::metrics).into_iter().flatten();
    let columns = names
        .map(|(name, ..)| Column { name: name.replace('_', ", "), unit: String::new(), better: manner(name).1 })
        .collect();
    let cells = |r: &EvalRow| {
        let cell = |(name, mean, error): (&str, f64, f64)| Cell::Value(estimate(mean, error, manner(name).0));
        r.metrics().into_iter().map(cell).collect()
    };
    let rows = e
        .rows
        .iter()
        .enumerate()
        .map(|(k, r)| TableRow { name: r.policy.clone(), emphasis: k == 0, cells: cells(r) })
        .collect();
    let caption = format!("Means over {} held-out worlds of seed {}, ± standard error.", s.eval_worlds, s.eval_seed);
    Table { corner: "policy".into(), columns, rows, caption }
}

fn charts(data: &Data, name: &str) -> Vec<Chart> {
    let by_rule = |metric: &str| -> Vec<Reference> {
        let rows = data.evaluation.iter().flat_map(|e| &e.rows).filter(|r| r.decide == "rule");
        rows.filter(|r| ["centroid", "greedy"].contains(&r.policy.as_str()))
            .filter_map(|r| {
                let y = r.metrics().into_iter().find(|(n, ..)| *n == metric)?.1;
                Some(Reference { name: r.policy.clone(), y })
            })
            .collect()
    };
    RoundMetrics::CHARTS
        .iter()
        .map(|&(title, y_label, metric, value)| {
            let points: Vec<_> = data.rows.iter().map(|r| (r.episodes as f64, value(r))).collect();
            Chart {
                title: title.into(),
                x_label: "episodes".into(),
                y_label: y_label.into(),
                y_range: None,
                series: vec![Series::binned(name, &points, BINS)],
                references: by_rule(metric),
            }
        })
        .collect()
}

fn configuration(s: &Settings) -> Vec<Group> {
    let entries = s.entries().into_iter().map(|(key, value)| (key.into(), value)).collect();
    vec![Group { name: "Settings".into(), entries }]
}

/// The first held-out world, flown by the run's actor file, if there is one.
fn episode(folder: &RunFolder, s: &Settings) -> Result<Option<Episode>> {
    let Some(bytes) = written(&folder.actor())? else { return Ok(None) };
    let actor = AnyActor::load_tested(&bytes).map_err(|e| miette!("{} cannot fly: {e}", folder.actor().display()))?;
    let t = EvalConfig::held_out(s);
    let seed = policy_seed(t.seed, 0);
    let trace = with_actor!(actor, actor => {
        Trace::record(&t.scenario, t.seed, 0, &mut ActorPolicy::new(*actor, seed, t.mode))
    })
    .into_diagnostic()?;
    Ok(Some(to_episode(&trace, &format!("World 0 of seed {}", t.seed))))
}

/// A trace as the page shows it.
fn to_episode(trace: &Trace, title: &str) -> Episode {
    let pair = |&(x, y): &(f32, f32)| [x, y];
    let frame = |f: &covey_env::Frame| Frame {
        uavs: f.uavs.iter().map(pair).collect(),
        edges: f.edges.iter().map(|&(a, b)| [a, b]).collect(),
        covered: f.covered.clone(),
        coverage: f.coverage as f32,
        actions: Vec::new(),
    };
    Episode {
        title: title.into(),
        side_u: trace.scenario.side_u,
        coverage_range_u: COVERAGE_RANGE_U as f32,
        observation_range_u: OBSERVATION_RANGE_U as f32,
        communication_range_u: COMMUNICATION_RANGE_U as f32,
        pois: trace.pois.iter().map(pair).collect(),
        action_names: Vec::new(),
        frames: trace.frames.iter().map(frame).collect(),
    }
}
