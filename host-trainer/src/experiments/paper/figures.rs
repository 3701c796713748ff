//! The paper's figures 5 to 14, and two that compare all policies.

use super::design::title;
use super::kind::Kind;
use super::metric::Metric;
use super::results::{Flight, Group, Results, RunResult};
use super::statistics::{mean, student};
use covey_report::report::{Chart, Series};

/// A figure's number in the paper, its file name without ending, and what it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Number in the paper.
    pub number: u8,
    /// File name.
    pub file: &'static str,
    /// What is drawn.
    pub metric: Metric,
    /// Whether over the number of UAVs, instead of training episodes.
    pub flights: bool,
}

const fn figure(number: u8, file: &'static str, metric: Metric, flights: bool) -> Figure {
    Figure { number, file, metric, flights }
}

/// The paper's.
pub const FIGURES: [Figure; 10] = [
    figure(5, "figure-05-reward.svg", Metric::Reward, false),
    figure(6, "figure-06-coverage.svg", Metric::Coverage, false),
    figure(7, "figure-07-energy.svg", Metric::Energy, false),
    figure(8, "figure-08-policy-loss.svg", Metric::PolicyLoss, false),
    figure(9, "figure-09-individual.svg", Metric::Individual, false),
    figure(10, "figure-10-group.svg", Metric::Group, false),
    figure(11, "figure-11-coverage-uavs.svg", Metric::Coverage, true),
    figure(12, "figure-12-energy-uavs.svg", Metric::Energy, true),
    figure(13, "figure-13-individual-uavs.svg", Metric::Individual, true),
    figure(14, "figure-14-group-uavs.svg", Metric::Group, true),
];

/// All policies beside each other: file name and metric.
pub const COMPARED: [(&str, Metric); 2] =
    [("compared-coverage.svg", Metric::Coverage), ("compared-reward.svg", Metric::Reward)];

/// Every chart with its file name.
#[must_use]
pub fn figures(results: &Results) -> Vec<(&'static str, Chart)> {
    let papers = results.group(Kind::Paper).into_iter().flat_map(|group| {
        FIGURES
            .iter()
            .map(|f| (f.file, if f.flights { over_uavs(group, f.metric) } else { over_training(group, f.metric) }))
    });
    papers.chain(COMPARED.map(|(file, metric)| (file, compared(results, metric)))).collect()
}

fn chart(metric: Metric, x_label: &str, series: Vec<Series>) -> Chart {
    let (title, y_label) = metric.labels();
    Chart {
        title: title.into(),
        x_label: x_label.into(),
        y_label: y_label.into(),
        y_range: None,
        series,
        references: Vec::new(),
    }
}

/// The mean over runs at each of `n` places, with its 95 % band.
fn series(
    name: String,
    runs: &[&RunResult],
    n: usize,
    place: impl Fn(&RunResult, usize) -> Option<(f64, f64)>,
) -> Series {
    let (mut points, mut band) = (Vec::new(), Vec::new());
    for k in 0..n {
        let found: Vec<(f64, f64)> = runs.iter().filter_map(|r| place(r, k)).collect();
        let values: Vec<f64> = found.iter().map(|p| p.1).collect();
        let Some(&(x, _)) = found.first() else { continue };
        points.push((x, mean(&values)));
        band.extend(student(&values).map(|i| (i.low, i.high)));
    }
    let band = Some(band).filter(|b| b.len() == points.len());
    Series { name, points, band }
}

fn over_training(group: &Group, metric: Metric) -> Chart {
    let one = |graph| {
        let runs: Vec<&RunResult> = group.of(graph).collect();
        let rounds = runs.iter().map(|r| r.curves.episodes.len()).min().unwrap_or(0);
        series(title(graph).into(), &runs, rounds, |r, k| Some((r.curves.episodes[k] as f64, r.curves.of(metric)[k])))
    };
    chart(metric, "episodes", group.graphs().into_iter().map(one).collect())
}

fn flown(f: &Flight, metric: Metric) -> Option<(f64, f64)> {
    Some((f64::from(f.uavs), f.of(metric)?))
}

fn group_over_uavs(group: &Group, metric: Metric, name: impl Fn(&str) -> String) -> Vec<Series> {
    let one = |graph| {
        let runs: Vec<&RunResult> = group.of(graph).collect();
        let sizes = runs.iter().map(|r| r.flights.len()).min().unwrap_or(0);
        series(name(title(graph)), &runs, sizes, |r, k| flown(&r.flights[k], metric))
    };
    group.graphs().into_iter().map(one).collect()
}

fn over_uavs(group: &Group, metric: Metric) -> Chart {
    chart(metric, "UAVs", group_over_uavs(group, metric, str::to_owned))
}

fn compared(results: &Results, metric: Metric) -> Chart {
    let mut all = Vec::new();
    for group in &results.groups {
        let of = if group.kind == Kind::Shipped { ", Covey" } else { "" };
        all.extend(group_over_uavs(group, metric, |name| format!("{name}{of}")));
    }
    for b in results.baselines.iter().filter(|b| b.policy != "random") {
        let points = b.flights.iter().filter_map(|f| flown(f, metric)).collect();
        all.push(Series { name: b.policy.clone(), points, band: None });
    }
    chart(metric, "UAVs", all)
}
