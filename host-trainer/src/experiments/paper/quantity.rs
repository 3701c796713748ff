//! Numbers taken from a run, and over seeds from runs.

use super::design::{ALGORITHMS, title};
use super::metric::Metric;
use super::results::{Curves, Group, Results, RunResult};
use super::statistics::{mean, scatter_around_line, slope};
use firmware_core::actor::Aggregation;

/// A number of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity(pub Metric, pub When);

/// Which part of a curve, or of the flights with other numbers of UAVs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// The first round.
    Start,
    /// Mean of the last tenth of training.
    End,
    /// After so many episodes, between the rounds around it.
    At(f64),
    /// Mean of the rounds between these episodes.
    Between(f64, f64),
    /// Mean of all training.
    Whole,
    /// Value at the end less that at the start.
    Change,
    /// The value after so many episodes less start.
    ChangeBy(f64),
    /// End less the value after so many episodes.
    ChangeFrom(f64),
    /// What was gained by so many episodes less what was gained from then to the end: above 0 when
    /// most of the gain comes early.
    GainByLessAfter(f64),
    /// Share of the change from start to end that was made by so many episodes.
    ShareBy(f64),
    /// Mean magnitude after so many episodes over the mean magnitude before.
    SizeAfterOverBefore(f64),
    /// Standard deviation of the rounds after so many episodes around their least-squares line.
    ScatterFrom(f64),
    /// Mean over all numbers of UAVs flown.
    Flights,
    /// Slope over the number of UAVs flown, for ten more.
    PerTenUavs,
    /// Lead over UAVs that fly at random, with the number of UAVs for which that lead is least.
    AboveRandom,
}

/// A number of every seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Mean over the paper's algorithms.
    Mean(Quantity),
    /// Least to greatest among the paper's algorithms.
    Spread(Quantity),
    /// One algorithm less another, same seed.
    Difference(Quantity, Aggregation, Aggregation),
    /// That difference as a share of the other.
    Relative(Quantity, Aggregation, Aggregation),
}

/// Rounds that lie wholly after `from` and before `to` episodes.
fn rounds(c: &Curves, from: f64, to: f64) -> impl Iterator<Item = usize> {
    let start = |k: usize| if k == 0 { 0 } else { c.episodes[k - 1] };
    (0..c.episodes.len()).filter(move |&k| start(k) as f64 >= from && c.episodes[k] as f64 <= to)
}

fn between(c: &Curves, metric: Metric, from: f64, to: f64) -> f64 {
    mean(&rounds(c, from, to).map(|k| c.of(metric)[k]).collect::<Vec<_>>())
}

/// After `episode` episodes: a round's mean stands at its middle, and between those it is a
/// straight line. Not a number beyond the last round.
fn at(c: &Curves, metric: Metric, episode: f64) -> f64 {
    let values = c.of(metric);
    let middle = |k: usize| (c.episodes[k] + if k == 0 { 0 } else { c.episodes[k - 1] }) as f64 / 2.0;
    let Some(next) = (0..values.len()).find(|&k| middle(k) >= episode) else { return f64::NAN };
    if next == 0 {
        return values[0];
    }
    let part = (episode - middle(next - 1)) / (middle(next) - middle(next - 1));
    values[next - 1] + part * (values[next] - values[next - 1])
}

impl Quantity {
    /// Of a run; not a number where its training was too short.
    #[must_use]
    pub fn of(self, run: &RunResult, results: &Results) -> f64 {
        let Self(metric, when) = self;
        let c = &run.curves;
        let last = c.episodes.last().copied().unwrap_or(0) as f64;
        let start = c.of(metric).first().copied().unwrap_or(f64::NAN);
        let end = || {
            let values = c.of(metric);
            mean(&values[values.len() - values.len().div_ceil(10)..])
        };
        let flights =
            || run.flights.iter().filter_map(|f| Some((f64::from(f.uavs), f.of(metric)?))).collect::<Vec<_>>();
        match when {
            When::Start => start,
            When::End => end(),
            When::At(episode) => at(c, metric, episode),
            When::Between(_, to) if to.is_finite() && to > last => f64::NAN,
            When::Between(from, to) => between(c, metric, from, to),
            When::Whole => mean(c.of(metric)),
            When::Change => end() - start,
            When::ChangeBy(episode) => at(c, metric, episode) - start,
            When::ChangeFrom(episode) => end() - at(c, metric, episode),
            When::GainByLessAfter(episode) => 2.0 * at(c, metric, episode) - start - end(),
            When::ShareBy(episode) => (at(c, metric, episode) - start) / (end() - start),
            When::SizeAfterOverBefore(episode) => {
                let size = |from, to| mean(&rounds(c, from, to).map(|k| c.of(metric)[k].abs()).collect::<Vec<_>>());
                size(episode, f64::INFINITY) / size(0.0, episode)
            }
            When::ScatterFrom(episode) => {
                let points = rounds(c, episode, f64::INFINITY).map(|k| (c.episodes[k] as f64, c.of(metric)[k]));
                scatter_around_line(&points.collect::<Vec<_>>())
            }
            When::Flights => mean(&flights().iter().map(|p| p.1).collect::<Vec<_>>()),
            When::PerTenUavs => 10.0 * slope(&flights()),
            When::AboveRandom => {
                let random = results.baselines.iter().find(|b| b.policy == "random");
                let least = |uavs: f64| random?.flights.iter().find(|f| f64::from(f.uavs) == uavs)?.of(metric);
                let above = flights().into_iter().map(|(uavs, v)| v - least(uavs).unwrap_or(f64::NAN));
                above.fold(f64::INFINITY, |a, b| if b.is_nan() { b } else { a.min(b) })
            }
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> String {
        let Self(metric, when) = self;
        let m = metric.name();
        match when {
            When::Start => format!("{m}, first round"),
            When::End => format!("{m}, last tenth of training"),
            When::At(e) => format!("{m} after {e:.0} episodes"),
            When::Between(from, to) if to.is_finite() => format!("{m}, mean of episodes {from:.0} to {to:.0}"),
            When::Between(from, _) => format!("{m}, mean from episode {from:.0} on"),
            When::Whole => format!("{m}, mean of all training"),
            When::Change => format!("{m}, end less start"),
            When::ChangeBy(e) => format!("{m} after {e:.0} episodes less start"),
            When::ChangeFrom(e) => format!("{m}, end less that after {e:.0} episodes"),
            When::GainByLessAfter(e) => format!("{m}, gain by {e:.0} episodes less gain after"),
            When::ShareBy(e) => format!("{m}, share of its change made by {e:.0} episodes"),
            When::SizeAfterOverBefore(e) => format!("{m}, mean size after {e:.0} episodes over that before"),
            When::ScatterFrom(e) => format!("{m}, deviation around a line from episode {e:.0} on"),
            When::Flights => format!("{m}, mean over the numbers of UAVs"),
            When::PerTenUavs => format!("{m}, slope for ten more UAVs"),
            When::AboveRandom => format!("{m} above random flight, least over the numbers of UAVs"),
        }
    }
}

impl Measure {
    /// One value a seed, for the seeds that have all the runs it needs.
    #[must_use]
    pub fn values(&self, group: &Group, results: &Results) -> Vec<f64> {
        let mut graphs = group.graphs();
        graphs.retain(|g| ALGORITHMS.contains(g));
        let of = |q: Quantity, graph, seed| group.run(graph, seed).map(|run| q.of(run, results));
        let all = |q: Quantity, seed| graphs.iter().map(|&g| of(q, g, seed)).collect::<Option<Vec<f64>>>();
        let value = |&seed: &u64| match *self {
            Self::Mean(q) => Some(mean(&all(q, seed)?)),
            Self::Spread(q) => {
                let values = all(q, seed).filter(|v| v.len() > 1 && v.iter().all(|x| x.is_finite()))?;
                let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
                Some(high - low)
            }
            Self::Difference(q, one, other) => Some(of(q, one, seed)? - of(q, other, seed)?),
            Self::Relative(q, one, other) => Some(of(q, one, seed)? / of(q, other, seed)? - 1.0),
        };
        group.seeds().iter().filter_map(value).collect()
    }

    /// In words.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Mean(q) => q.words(),
            Self::Spread(q) => format!("{}, greatest less least algorithm", q.words()),
            Self::Difference(q, one, other) => format!("{}: {} − {}", q.words(), title(*one), title(*other)),
            Self::Relative(q, one, other) => format!("{}: {} ÷ {} − 1", q.words(), title(*one), title(*other)),
        }
    }
}

/// The first episode at whose round's end the metric had reached `level`.
#[must_use]
pub fn reached(run: &RunResult, metric: Metric, level: f64) -> Option<u64> {
    let c = &run.curves;
    c.of(metric).iter().position(|&v| v >= level).map(|k| c.episodes[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::paper::{Baseline, Flight};
    use covey_env::EpisodeMetrics;

    /// Ten rounds of 100 episodes in which coverage rises by 0.01 a round from 0.1, with a
    /// policy loss of −4 and then −1; flights that cover 0.02 a UAV.
    fn run() -> RunResult {
        let ten = |f: fn(u32) -> f64| (0..10).map(f).collect::<Vec<_>>();
        let curves = Curves {
            episodes: (1..=10).map(|k| 100 * k).collect(),
            reward: ten(f64::from),
            coverage: ten(|k| 0.1 + 0.01 * f64::from(k)),
            energy: ten(|k| if k % 2 == 0 { 0.9 } else { 0.7 }),
            policy_loss: ten(|k| if k < 5 { -4.0 } else { -1.0 }),
            individual: ten(|_| 1.0),
            group: ten(|_| 2.0),
        };
        RunResult { graph: "gcn".into(), seed: 1, curves, flights: flights(0.02) }
    }

    fn flights(each: f64) -> Vec<Flight> {
        let mean = |uavs: u16| EpisodeMetrics { coverage: each * f64::from(uavs), ..EpisodeMetrics::default() };
        [5, 10, 30].map(|uavs| Flight { uavs, mean: mean(uavs) }).to_vec()
    }

    #[test]
    fn every_part_of_a_curve_is_what_it_says() {
        let random = Baseline { policy: "random".into(), flights: flights(0.01) };
        let results = Results::new(vec![5, 10, 30], 1, 1, Vec::new(), vec![random]);
        let is = |metric, when, wanted: f64| {
            let found = Quantity(metric, when).of(&run(), &results);
            assert!(
                (found - wanted).abs() < 1e-12 || found.is_nan() && wanted.is_nan(),
                "{metric:?} {when:?}: {found}"
            );
        };
        let coverage = |when, wanted| is(Metric::Coverage, when, wanted);
        coverage(When::Start, 0.1);
        coverage(When::End, 0.19);
        coverage(When::At(20.0), 0.1);
        coverage(When::At(100.0), 0.105);
        coverage(When::At(150.0), 0.11);
        coverage(When::At(951.0), f64::NAN);
        coverage(When::Between(0.0, 299.0), 0.105);
        coverage(When::Between(200.0, 400.0), 0.125);
        coverage(When::Between(800.0, f64::INFINITY), 0.185);
        coverage(When::Between(0.0, 1001.0), f64::NAN);
        coverage(When::Between(1000.0, f64::INFINITY), f64::NAN);
        coverage(When::Whole, 0.145);
        coverage(When::Change, 0.09);
        coverage(When::ChangeBy(450.0), 0.04);
        coverage(When::ChangeFrom(450.0), 0.05);
        coverage(When::GainByLessAfter(450.0), -0.01);
        coverage(When::ShareBy(450.0), 4.0 / 9.0);
        coverage(When::ScatterFrom(0.0), 0.0);
        coverage(When::Flights, 0.3);
        coverage(When::PerTenUavs, 0.2);
        coverage(When::AboveRandom, 0.05);
        is(Metric::PolicyLoss, When::SizeAfterOverBefore(500.0), 0.25);
        is(Metric::PolicyLoss, When::Flights, f64::NAN);
        assert_eq!(reached(&run(), Metric::Coverage, 0.115), Some(300));
        assert_eq!(reached(&run(), Metric::Coverage, 0.2), None);
    }
}
