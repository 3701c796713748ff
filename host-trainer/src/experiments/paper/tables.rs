//! Tables in Markdown.

use super::design::title;
use super::kind::Kind;
use super::metric::Metric;
use super::quantity::reached;
use super::results::{Flight, Group, Results};
use super::statistics::{Interval, interquartile, interquartile_mean, student};
use std::fmt::Write;

/// Text with a true minus sign.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// `0.512 [0.498, 0.520]`.
pub(super) fn interval(i: Interval, decimals: usize) -> String {
    format!("{} [{}, {}]", number(i.value, decimals), number(i.low, decimals), number(i.high, decimals))
}

/// Interquartile mean with its interval where there are several runs.
fn middle(values: &[f64], decimals: usize) -> String {
    match interquartile(values) {
        Some(i) => interval(i, decimals),
        None if values.is_empty() => "–".into(),
        None => number(interquartile_mean(values), decimals),
    }
}

fn head(out: &mut String, corner: &str, columns: impl IntoIterator<Item = String>) {
    let columns: Vec<String> = columns.into_iter().collect();
    let _ = writeln!(out, "| {corner} | {} |\n|---|{}", columns.join(" | "), "--:|".repeat(columns.len()));
}

/// Every algorithm at the end of training.
pub(super) fn end_of_training(group: &Group) -> String {
    const METRICS: [Metric; 5] = [Metric::Reward, Metric::Coverage, Metric::Energy, Metric::Individual, Metric::Group];
    let mut out = String::new();
    head(&mut out, "algorithm", METRICS.map(|m| m.name().to_owned()));
    for graph in group.graphs() {
        let cell = |metric: Metric| {
            let ends = group.of(graph).map(|r| {
                let values = r.curves.of(metric);
                super::statistics::mean(&values[values.len() - values.len().div_ceil(10)..])
            });
            middle(&ends.collect::<Vec<_>>(), metric.decimals())
        };
        let _ = writeln!(out, "| {} | {} |", title(graph), METRICS.map(cell).join(" | "));
    }
    out
}

/// When coverage first reached some levels.
pub(super) fn coverage_reached(group: &Group) -> String {
    const LEVELS: [f64; 4] = [0.2, 0.3, 0.4, 0.5];
    let mut out = String::new();
    head(&mut out, "algorithm", LEVELS.map(|l| format!("{l}")));
    for graph in group.graphs() {
        let cell = |level| {
            let found: Vec<Option<u64>> = group.of(graph).map(|r| reached(r, Metric::Coverage, level)).collect();
            let (low, high) = (found.iter().flatten().min(), found.iter().flatten().max());
            let missing = found.iter().filter(|f| f.is_none()).count();
            match (low, high) {
                (Some(low), Some(high)) => {
                    let range = if low == high { low.to_string() } else { format!("{low} to {high}") };
                    if missing == 0 { range } else { format!("{range}; {missing} of {} never", found.len()) }
                }
                _ => "never".into(),
            }
        };
        let _ = writeln!(out, "| {} | {} |", title(graph), LEVELS.map(cell).join(" | "));
    }
    out
}

/// A metric by number of UAVs for every algorithm of a group.
pub(super) fn by_uavs(group: &Group, sizes: &[u16], metric: Metric) -> String {
    let mut out = String::new();
    head(&mut out, "UAVs", sizes.iter().map(u16::to_string));
    for line in rows_by_uavs(group, sizes, metric, "") {
        out += &line;
    }
    out
}

fn rows_by_uavs(group: &Group, sizes: &[u16], metric: Metric, suffix: &str) -> Vec<String> {
    let row = |graph| {
        let cells = sizes.iter().map(|&uavs| {
            let found = group.of(graph).filter_map(|r| at(&r.flights, uavs)?.of(metric));
            middle(&found.collect::<Vec<_>>(), metric.decimals())
        });
        format!("| {}{suffix} | {} |\n", title(graph), cells.collect::<Vec<_>>().join(" | "))
    };
    group.graphs().into_iter().map(row).collect()
}

pub(super) fn at(flights: &[Flight], uavs: u16) -> Option<&Flight> {
    flights.iter().find(|f| f.uavs == uavs)
}

/// All policies beside each other.
pub(super) fn beside_baselines(results: &Results, metric: Metric) -> String {
    let mut out = String::new();
    head(&mut out, "UAVs", results.sizes.iter().map(u16::to_string));
    for group in &results.groups {
        let suffix = match group.kind {
            Kind::Paper => ", the paper's setting",
            Kind::Shipped => ", Covey's defaults",
        };
        rows_by_uavs(group, &results.sizes, metric, suffix).iter().for_each(|line| out += line);
    }
    for b in &results.baselines {
        let cell = |&uavs: &u16| {
            at(&b.flights, uavs).and_then(|f| f.of(metric)).map_or("–".into(), |v| number(v, metric.decimals()))
        };
        let _ =
            writeln!(out, "| *{}* | {} |", b.policy, results.sizes.iter().map(cell).collect::<Vec<_>>().join(" | "));
    }
    out
}

/// Pairs of values as a row: mean difference with its Student interval, and whether it is
/// above 0, below or neither.
pub(super) fn difference(differences: &[f64], decimals: usize) -> String {
    match student(differences) {
        Some(i) if i.low > 0.0 => format!("**{}** above", interval(i, decimals)),
        Some(i) if i.high < 0.0 => format!("{} below", interval(i, decimals)),
        Some(i) => format!("{} not separable", interval(i, decimals)),
        None => "–".into(),
    }
}
