//! A report that compares several runs.

use serde::{Deserialize, Serialize};

use super::chart::Chart;
use super::model::{Content, Figure, Group, Report, Section};
use super::table::{Better, Cell, Column, Estimate, Row, Table};

/// What a comparison shows of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the run: it stands in the table and in the legend.
    pub name: String,
    /// Its headline figures. Those with the same label share a column.
    pub figures: Vec<(Figure, Better)>,
    /// Its settings.
    pub configuration: Vec<Group>,
    /// Its curves. Charts with the same title are laid over each other.
    pub charts: Vec<Chart>,
}

/// A report of several runs: a table of their figures, where their settings differ,
/// and their curves over each other.
#[must_use]
pub fn comparison(title: impl Into<String>, subtitle: impl Into<String>, runs: &[Run]) -> Report {
    let section = |title: &str, lead: &str, content| Section { title: title.into(), lead: lead.into(), content };
    let mut sections = vec![section("Results", "", Content::Table(figures(runs)))];
    let charts = overlaid(runs);
    if !charts.is_empty() {
        sections.push(section("Curves", "Click a name to hide or show its curves.", Content::Charts(charts)));
    }
    let differences = differences(runs);
    let lead = match differences.rows.is_empty() {
        true => "All runs have the same settings.",
        false => "Only the settings that differ between the runs.",
    };
    let content = if differences.rows.is_empty() { Content::Text } else { Content::Table(differences) };
    sections.push(section("Settings", lead, content));
    Report { title: title.into(), subtitle: subtitle.into(), sections }
}

fn figures(runs: &[Run]) -> Table {
    let mut columns: Vec<Column> = Vec::new();
    for (figure, better) in runs.iter().flat_map(|r| &r.figures) {
        if !columns.iter().any(|c| c.name == figure.label) {
            columns.push(Column { name: figure.label.clone(), unit: figure.unit.clone(), better: *better });
        }
    }
    let row = |run: &Run| {
        let cell = |column: &Column| {
            let figure = run.figures.iter().find(|(f, _)| f.label == column.name);
            figure.map_or(Cell::Empty, |(f, _)| Cell::Value(f.value))
        };
        Row { name: run.name.clone(), emphasis: false, cells: columns.iter().map(cell).collect() }
    };
    let rows = runs.iter().map(row).collect();
    let has_error = |(f, _): &(Figure, Better)| matches!(f.value, Estimate { standard_error: Some(_), .. });
    let errors = runs.iter().flat_map(|r| &r.figures).any(has_error);
    let caption = if errors { "± standard error of the mean" } else { "" }.into();
    Table { corner: "Run".into(), columns, rows, caption }
}

fn overlaid(runs: &[Run]) -> Vec<Chart> {
    let mut charts: Vec<Chart> = Vec::new();
    for run in runs {
        for chart in &run.charts {
            let at = charts.iter().position(|c| c.title == chart.title).unwrap_or_else(|| {
                charts.push(Chart { series: Vec::new(), ..chart.clone() });
                charts.len() - 1
            });
            let alone = chart.series.len() == 1;
            charts[at].series.extend(chart.series.iter().cloned().map(|mut series| {
                series.name = if alone { run.name.clone() } else { format!("{}: {}", run.name, series.name) };
                series
            }));
        }
    }
    charts
}

fn differences(runs: &[Run]) -> Table {
    let mut names: Vec<(&str, &str)> = Vec::new();
    for group in runs.iter().flat_map(|r| &r.configuration) {
        for (name, _) in &group.entries {
            if !names.contains(&(&group.name, name)) {
                names.push((&group.name, name));
            }
        }
    }
    let value = |run: &Run, (group, name): (&str, &str)| {
        let entries = run.configuration.iter().filter(|g| g.name == group).flat_map(|g| &g.entries);
        entries.clone().find(|(n, _)| n == name).map(|(_, v)| v.clone())
    };
    let row = |at: &(&str, &str)| {
        let values: Vec<_> = runs.iter().map(|run| value(run, *at)).collect();
        let differ = values.windows(2).any(|w| w[0] != w[1]);
        let name = if at.0.is_empty() { at.1.into() } else { format!("{}: {}", at.0, at.1) };
        let cells = values.into_iter().map(|v| v.map_or(Cell::Empty, Cell::Text)).collect();
        differ.then_some(Row { name, emphasis: false, cells })
    };
    let column = |run: &Run| Column { name: run.name.clone(), ..Column::default() };
    Table {
        corner: "Setting".into(),
        columns: runs.iter().map(column).collect(),
        rows: names.iter().filter_map(row).collect(),
        caption: String::new(),
    }
}
