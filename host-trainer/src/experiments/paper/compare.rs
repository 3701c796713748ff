//! One group beside the other: what Covey's defaults add to the paper's setting.

use super::design::title;
use super::kind::Kind;
use super::metric::Metric;
use super::results::{Group, Results, RunResult};
use super::tables::{at, difference};
use firmware_core::actor::Aggregation;
use std::fmt::Write;

/// A policy against another, seed by seed.
struct Pair<'a> {
    one: (&'a Group, Aggregation),
    other: (&'a Group, Aggregation),
}

impl Pair<'_> {
    fn name(&self) -> String {
        let of = |(group, graph): (&Group, Aggregation)| format!("{}, {}", title(graph), group.kind.title());
        format!("{} − {}", of(self.one), of(self.other))
    }

    /// Differences of a metric of flights with `uavs` UAVs, or of their mean over all sizes.
    fn differences(&self, metric: Metric, uavs: Option<u16>) -> Vec<f64> {
        let value = |run: &RunResult| match uavs {
            Some(uavs) => at(&run.flights, uavs)?.of(metric),
            None => Some(super::statistics::mean(&run.flights.iter().filter_map(|f| f.of(metric)).collect::<Vec<_>>())),
        };
        let seed = |&seed: &u64| {
            let of = |(group, graph): (&Group, Aggregation)| value(group.run(graph, seed)?);
            Some(of(self.one)? - of(self.other)?)
        };
        self.one.0.seeds().iter().filter_map(seed).collect()
    }
}

/// Every pair that is of interest: each graph form against plain PPO of its own group, and
/// Covey's defaults against the same algorithm and plain PPO in the paper's setting.
fn pairs(results: &Results) -> Vec<Pair<'_>> {
    let mut found = Vec::new();
    for group in &results.groups {
        for graph in group.graphs().into_iter().filter(|&g| g != Aggregation::None) {
            found.push(Pair { one: (group, graph), other: (group, Aggregation::None) });
        }
    }
    if let (Some(paper), Some(shipped)) = (results.group(Kind::Paper), results.group(Kind::Shipped)) {
        for graph in shipped.graphs() {
            found.push(Pair { one: (shipped, graph), other: (paper, graph) });
            if graph != Aggregation::None {
                found.push(Pair { one: (shipped, graph), other: (paper, Aggregation::None) });
            }
        }
    }
    found
}

/// Differences by number of UAVs and in the mean, a table for coverage and one for reward.
pub(super) fn improvements(results: &Results) -> String {
    let mut out = String::new();
    for metric in [Metric::Coverage, Metric::Reward, Metric::Energy] {
        let decimals = metric.decimals();
        let sizes: String = results.sizes.iter().map(|s| format!(" {s} |")).collect();
        let _ = writeln!(out, "\n{} with so many UAVs:\n", metric.labels().0);
        let _ = writeln!(out, "| difference |{sizes} mean |\n|---|{}", "--:|".repeat(results.sizes.len() + 1));
        for pair in pairs(results) {
            let sizes = results.sizes.iter().copied().map(Some).chain([None]);
            let cells = sizes.map(|size| format!(" {} |", difference(&pair.differences(metric, size), decimals)));
            let _ = writeln!(out, "| {} |{}", pair.name(), cells.collect::<String>());
        }
    }
    out
}
