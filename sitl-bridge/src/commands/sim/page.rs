//! The flights of a simulated swarm as an HTML page: they play, beside the trainer's own flights
//! of the same worlds, with coverage over time.

use super::{Simulation, WorldFlight, policy_seed};
use crate::summary::Summary;
use covey_env::{ActorPolicy, Frame as EnvFrame, ScenarioError, Trace, World};
use covey_report::report::{
    Better, Cell, Chart, Column, Content, Episode, Estimate, Figure, Frame, Group, Report, ReportError, Row, Section,
    Series, Table,
};
use firmware_core::action::Action;
use firmware_core::actor::Mode;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U, State};
use std::path::Path;
use thiserror::Error;

/// Worlds that play in the page; of more there are only the figures.
const PLAYED: usize = 10;
/// Names of the curves.
const FLOWN: &str = "flown";
const TRAINER: &str = "trainer's evaluation";

/// Why there is no page.
#[derive(Debug, Error)]
pub enum PageError {
    /// The scenario cannot be.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The page cannot be made or written.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// The page of a simulation, world by world.
#[derive(Clone, Debug, Default)]
pub struct Page {
    episodes: Vec<Episode>,
    charts: Vec<Chart>,
    rows: Vec<Row>,
    /// Sums over worlds of the share covered after each step: flown and the trainer's.
    sums: [Vec<f64>; 2],
}

impl Page {
    /// Adds a world that was flown.
    ///
    /// # Errors
    /// The simulation's scenario cannot be.
    pub fn add(&mut self, sim: &Simulation<'_>, index: u64, flight: &WorldFlight) -> Result<(), PageError> {
        for (sum, shares) in self.sums.iter_mut().zip([&flight.coverage, &flight.trainer_coverage]) {
            sum.resize(shares.len().max(sum.len()), 0.0);
            sum.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share);
        }
        self.rows.push(row(index, flight));
        if self.charts.len() < PLAYED {
            let mut world = World::new(&sim.scenario)?;
            world.reset(sim.seed, index);
            self.charts.push(chart(format!("World {index}"), &flight.coverage, &flight.trainer_coverage));
            self.episodes.push(flown(index, &world, flight));
            self.episodes.push(trained(sim, index, &mut world));
        }
        Ok(())
    }

    /// The report.
    #[must_use]
    pub fn report(&self, sim: &Simulation<'_>, summary: &Summary) -> Report {
        let section = |title: &str, lead: &str, content| Section { title: title.into(), lead: lead.into(), content };
        let worlds = self.rows.len();
        let mut charts = self.charts.clone();
        if worlds > 1 {
            let [flown, trained] =
                [0, 1].map(|k: usize| self.sums[k].iter().map(|s| s / worlds as f64).collect::<Vec<_>>());
            charts.insert(0, chart(format!("Mean of {worlds} worlds"), &flown, &trained));
        }
        let table =
            Table { corner: "world".into(), columns: columns(), rows: self.rows.clone(), caption: caption(sim) };
        let sections = vec![
            section("Result", "Over all worlds flown.", Content::Figures(figures(summary))),
            section(
                "The flight",
                "What the nodes measured, and the trainer's own flight of the same world. Space plays, arrow keys step.",
                Content::Episodes(self.episodes.clone()),
            ),
            section("Coverage over time", "Share of PoIs covered after each step.", Content::Charts(charts)),
            section("World by world", "", Content::Table(table)),
            section("Settings and messages", "", Content::Configuration(configuration(sim, summary))),
        ];
        let scenario = &sim.scenario;
        Report {
            title: format!("Covey: {} UAVs over simulated autopilots", scenario.uavs),
            subtitle: format!(
                "{worlds} world{} of seed {} · {} PoIs · {} steps",
                if worlds == 1 { "" } else { "s" },
                sim.seed,
                scenario.pois,
                scenario.steps
            ),
            sections,
        }
    }

    /// Writes the page.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path, sim: &Simulation<'_>, summary: &Summary) -> Result<(), PageError> {
        Ok(self.report(sim, summary).write(path)?)
    }
}

/// The flight as the nodes measured it.
fn flown(index: u64, world: &World, flight: &WorldFlight) -> Episode {
    let pois: Vec<_> = world.poi_x().iter().zip(world.poi_y()).map(|(&x, &y)| [x, y]).collect();
    let place = |state: &Option<State>| {
        state.map_or([f32::NAN; 2], |state| {
            let (x, y) = state.position.to_u();
            [x, y]
        })
    };
    let frame = |(step, row): (usize, &Vec<Option<State>>)| {
        let uavs: Vec<[f32; 2]> = row.iter().map(place).collect();
        let near = |poi: &[f32; 2]| uavs.iter().any(|uav| within(*uav, *poi, COVERAGE_RANGE_U));
        let covered: Vec<bool> = pois.iter().map(near).collect();
        let coverage = match step.checked_sub(1).and_then(|done| flight.coverage.get(done)) {
            Some(&share) => share as f32,
            None => covered.iter().filter(|&&c| c).count() as f32 / pois.len().max(1) as f32,
        };
        let actions =
            step.checked_sub(1).and_then(|done| flight.decisions.get(done)).map_or_else(Vec::new, |decisions| {
                let all: Option<Vec<u8>> = decisions.iter().map(|d| d.map(|d| d.action)).collect();
                all.unwrap_or_default()
            });
        Frame { edges: links(flight, step, &uavs), uavs, covered, coverage, actions }
    };
    Episode {
        action_names: Action::all().map(name).collect(),
        frames: flight.states.iter().enumerate().map(frame).collect(),
        ..episode(format!("World {index}, flown"), world, pois.clone())
    }
}

/// Who heard whom: the neighbours that decisions were made on. After the last decision, who was near.
fn links(flight: &WorldFlight, step: usize, uavs: &[[f32; 2]]) -> Vec<[u16; 2]> {
    let mut links: Vec<[u16; 2]> = match flight.decisions.get(step) {
        Some(row) => (0u16..)
            .zip(row)
            .flat_map(|(i, decision)| {
                let seen = decision.as_ref().map_or(&[][..], |d| d.neighbours());
                seen.iter().map(move |&j| [i.min(j), i.max(j)]).collect::<Vec<_>>()
            })
            .filter(|link| usize::from(link[1]) < uavs.len())
            .collect(),
        None => {
            let ids = 0..uavs.len();
            let pairs = ids.clone().flat_map(|i| ids.clone().skip(i + 1).map(move |j| (i, j)));
            pairs
                .filter(|&(i, j)| within(uavs[i], uavs[j], COMMUNICATION_RANGE_U))
                .map(|(i, j)| [i as u16, j as u16])
                .collect()
        }
    };
    links.sort_unstable();
    links.dedup();
    links
}

/// Of what is not there nothing is near.
fn within(a: [f32; 2], b: [f32; 2], range_u: i32) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) <= range_u as f32
}

/// The trainer's flight of the same world.
fn trained(sim: &Simulation<'_>, index: u64, world: &mut World) -> Episode {
    let mut policy = ActorPolicy::new(sim.actor, policy_seed(sim.seed, index), sim.mode);
    let trace = Trace::record_in(world, &mut policy);
    let pair = |&(x, y): &(f32, f32)| [x, y];
    let frame = |f: &EnvFrame| Frame {
        uavs: f.uavs.iter().map(pair).collect(),
        edges: f.edges.iter().map(|&(a, b)| [a, b]).collect(),
        covered: f.covered.clone(),
        coverage: f.coverage as f32,
        actions: Vec::new(),
    };
    let pois = trace.pois.iter().map(pair).collect();
    Episode {
        frames: trace.frames.iter().map(frame).collect(),
        ..episode(format!("World {index}, trainer's evaluation"), world, pois)
    }
}

fn episode(title: String, world: &World, pois: Vec<[f32; 2]>) -> Episode {
    Episode {
        title,
        side_u: world.scenario().side_u,
        coverage_range_u: COVERAGE_RANGE_U as f32,
        observation_range_u: OBSERVATION_RANGE_U as f32,
        communication_range_u: COMMUNICATION_RANGE_U as f32,
        pois,
        ..Episode::default()
    }
}

/// An action in words.
fn name(action: Action) -> String {
    const DIRECTIONS: [&str; 8] =
        ["east", "south-east", "south", "south-west", "west", "north-west", "north", "north-east"];
    let index = usize::from(action.index());
    match DIRECTIONS.get(index % 8) {
        Some(direction) if index < 16 => format!("{} {direction}", if index < 8 { "4 u/step²" } else { "2 u/step²" }),
        _ => "coast".into(),
    }
}

fn chart(title: String, flown: &[f64], trained: &[f64]) -> Chart {
    let series = |name: &str, shares: &[f64]| Series {
        name: name.into(),
        points: (1..).zip(shares).map(|(step, &share)| (f64::from(step), share)).collect(),
        band: None,
    };
    Chart {
        title,
        x_label: "steps".into(),
        y_label: "share of PoIs covered".into(),
        y_range: None,
        series: vec![series(FLOWN, flown), series(TRAINER, trained)],
        references: Vec::new(),
    }
}

const fn estimate(mean: f64, decimals: usize) -> Estimate {
    Estimate { mean, standard_error: None, decimals }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn figures(summary: &Summary) -> Vec<Figure> {
    let figure =
        |label: &str, value, unit: &str, note: String| Figure { label: label.into(), value, unit: unit.into(), note };
    let share = |part: u64, whole: u64| estimate(100.0 * part as f64 / whole.max(1) as f64, 1);
    let trained = summary.trainer_coverage_mean;
    vec![
        figure("Coverage index, flown", estimate(summary.coverage_mean, 3), "", "as the nodes measured it".into()),
        figure("Coverage index, trainer", estimate(trained, 3), "", "int8 evaluation of the same worlds".into()),
        figure(
            "ActorInput of the trainer's",
            estimate(100.0 * summary.coverage_mean / trained.max(1e-9), 1),
            "%",
            String::new(),
        ),
        figure(
            "Decisions as the trainer's",
            share(summary.decisions_equal_to_trainer, summary.decisions_compared),
            "%",
            format!("of {} compared", summary.decisions_compared),
        ),
        figure("Faster than real time", estimate(summary.realtime_factor, 1), "×", "from step 0 to the last".into()),
    ]
}

fn columns() -> Vec<Column> {
    let column = |name: &str, better| Column { name: name.into(), unit: String::new(), better };
    vec![
        column("coverage flown", Better::Higher),
        column("by true positions", Better::Neither),
        column("trainer's", Better::Neither),
        column("decisions as the trainer's", Better::Neither),
        column("late", Better::Lower),
        column("missed", Better::Lower),
        column("troubles", Better::Lower),
    ]
}

fn row(index: u64, flight: &WorldFlight) -> Row {
    let value = |mean, decimals| Cell::Value(estimate(mean, decimals));
    let count = |count: u64| value(count as f64, 0);
    Row {
        name: index.to_string(),
        emphasis: false,
        cells: vec![
            value(mean(&flight.coverage), 3),
            value(mean(&flight.true_coverage), 3),
            value(mean(&flight.trainer_coverage), 3),
            Cell::Text(format!("{} of {}", flight.equal, flight.compared)),
            count(flight.counters.late_decisions),
            count(flight.counters.missed_decisions),
            count(flight.trouble.len() as u64),
        ],
    }
}

fn caption(sim: &Simulation<'_>) -> String {
    let compared = if sim.ideal {
        "its own flight of the world"
    } else {
        "what it would do in the situations that were measured, all neighbours heard"
    };
    format!("Decisions are compared with the trainer's in {compared}. Troubles are time-outs, failsafes and crashes.")
}

fn configuration(sim: &Simulation<'_>, summary: &Summary) -> Vec<Group> {
    let entry = |name: &str, value: String| (name.to_owned(), value);
    let (scenario, timing) = (&sim.scenario, &sim.timing);
    let group = |name: &str, entries| Group { name: name.into(), entries };
    let flight = vec![
        entry("UAVs", scenario.uavs.to_string()),
        entry("map", format!("{0} u × {0} u", scenario.side_u)),
        entry("autopilots", if sim.px4 { "PX4" } else { "ArduPilot" }.into()),
        entry("dynamics", if sim.ideal { "the scenario's own" } else { "point mass with lag and drag" }.into()),
        entry("pace", sim.speed.map_or_else(|| "lock-step".into(), |speed| format!("{speed} × real time"))),
        entry("actions", if sim.mode == Mode::Argmax { "most likely" } else { "drawn" }.into()),
        entry("telemetry", format!("{} Hz", sim.rate_hz)),
        entry("encodes, decides", format!("{} ms, {} ms into a step", timing.encode_ms, timing.decide_ms)),
        entry("actor", format!("{:016x}", sim.actor.content_hash())),
    ];
    let mut messages =
        vec![entry("sent", summary.messages_sent.to_string()), entry("used", summary.messages_received.to_string())];
    messages.extend(summary.messages_rejected.iter().map(|(reason, count)| entry(reason, count.to_string())));
    let mut groups = vec![group("Flight", flight), group("Neighbour messages", messages)];
    if !sim.fleet.is_empty() {
        let entries = sim.fleet.iter().map(|(name, value)| entry(name, value.to_string())).collect();
        groups.push(group("Fleet", entries));
    }
    groups
}
