//! The page of a simulation: flights that play beside the trainer's own flights of the same worlds,
//! with coverage over time.

use super::episodes::{flown, trained};
use super::tables::{caption, columns, configuration, figures, row};
use crate::simulation::settings::Simulation;
use crate::simulation::summary::Summary;
use crate::simulation::world_flight::WorldFlight;
use covey_env::{ScenarioError, World};
use covey_report::report::{Chart, Content, Episode, Report, ReportError, Row, Section, Series, Table};
use std::path::Path;
use thiserror::Error;

/// Worlds that play in the page; of more there are only the figures.
const PLAYED: usize = 10;
/// Names of the curves.
const FLOWN: &str = "flown";
const TRAINER: &str = "trainer's evaluation";

/// Why the page cannot be made.
#[derive(Debug, Error)]
pub enum PageError {
    /// The scenario's settings contradict each other.
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
    /// The scenario's settings contradict each other.
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

    /// The page's content.
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
            title: format!(
                "Covey: {} UAVs over {}",
                scenario.uavs,
                if sim.autopilots.is_real() { sim.autopilots.to_string() } else { "simulated autopilots".into() }
            ),
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
    /// The file cannot be written.
    pub fn write(&self, path: &Path, sim: &Simulation<'_>, summary: &Summary) -> Result<(), PageError> {
        Ok(self.report(sim, summary).write(path)?)
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
