//! What section 4 of the paper says of its figures, in our words, each with the measurement
//! that decides on it.

use super::judge::{Criterion, Finding, judge};
use super::metric::Metric;
use super::quantity::{Measure, Quantity, When};
use super::results::{Group, Results};
use super::statistics::student;
use firmware_core::actor::Aggregation::{self, Gat, Gcn, None as Plain};

/// One statement of the paper.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// The figure it is about.
    pub figure: u8,
    /// The statement in our words.
    pub statement: &'static str,
    /// What is measured.
    pub measure: Measure,
    /// What that must be for the statement to hold.
    pub criterion: Criterion,
}

/// Two curves are "about equal" when they differ by less than this share.
const ALIKE: Criterion = Criterion::Within(-0.05, 0.05);
/// A change is "made" when this share of it is.
const MADE: Criterion = Criterion::Above(0.9);
/// From this episode on, as far as training went.
const ON: f64 = f64::INFINITY;

const POSITIVE: Criterion = Criterion::Above(0.0);
const NEGATIVE: Criterion = Criterion::Below(0.0);

const fn claim(figure: u8, statement: &'static str, measure: Measure, criterion: Criterion) -> Claim {
    Claim { figure, statement, measure, criterion }
}

const fn all(metric: Metric, when: When) -> Measure {
    Measure::Mean(Quantity(metric, when))
}

const fn less(metric: Metric, when: When, one: Aggregation, other: Aggregation) -> Measure {
    Measure::Difference(Quantity(metric, when), one, other)
}

const fn over(metric: Metric, when: When, one: Aggregation, other: Aggregation) -> Measure {
    Measure::Relative(Quantity(metric, when), one, other)
}

use Metric::{Coverage, Energy, Group as Grouped, Individual, PolicyLoss, Reward};
use When::{
    AboveRandom, At, Between, Change, ChangeBy, ChangeFrom, End, Flights, GainByLessAfter, PerTenUavs, ScatterFrom,
    ShareBy, SizeAfterOverBefore, Start, Whole,
};

/// Every statement, by figure.
pub const CLAIMS: &[Claim] = &[
    claim(5, "PPO with GCN ends with more reward than plain PPO", less(Reward, End, Gcn, Plain), POSITIVE),
    claim(5, "PPO with GAT ends with more reward than plain PPO", less(Reward, End, Gat, Plain), POSITIVE),
    claim(5, "GCN and GAT have about the same reward once converged", over(Reward, End, Gat, Gcn), ALIKE),
    claim(5, "GCN learns faster than plain PPO", less(Reward, Between(0.0, 1000.0), Gcn, Plain), POSITIVE),
    claim(5, "GCN learns faster than GAT", less(Reward, Between(0.0, 1000.0), Gcn, Gat), POSITIVE),
    claim(
        5,
        "GAT learns more slowly than plain PPO in the first 2,000 episodes",
        less(Reward, Between(0.0, 2000.0), Gat, Plain),
        NEGATIVE,
    ),
    claim(
        5,
        "GAT is better than plain PPO after 2,000 episodes",
        less(Reward, Between(2000.0, ON), Gat, Plain),
        POSITIVE,
    ),
    claim(6, "coverage is 0.2 at the start", all(Coverage, Start), Criterion::Within(0.15, 0.25)),
    claim(6, "coverage reaches 0.3 after 100 episodes", all(Coverage, At(100.0)), Criterion::Above(0.3)),
    claim(6, "coverage reaches 0.4 after 200 episodes", all(Coverage, At(200.0)), Criterion::Above(0.4)),
    claim(6, "all three improve in the first 200 episodes", all(Coverage, ChangeBy(200.0)), POSITIVE),
    claim(
        6,
        "after 500 episodes all three stand at a similar level",
        Measure::Spread(Quantity(Coverage, At(500.0))),
        Criterion::Below(0.05),
    ),
    claim(6, "after 500 episodes coverage grows only slowly", all(Coverage, GainByLessAfter(500.0)), POSITIVE),
    claim(6, "GCN leads over plain PPO throughout", less(Coverage, Whole, Gcn, Plain), POSITIVE),
    claim(6, "but by little", over(Coverage, Whole, Gcn, Plain), ALIKE),
    claim(
        6,
        "GAT lags behind plain PPO before 2,000 episodes",
        less(Coverage, Between(0.0, 2000.0), Gat, Plain),
        NEGATIVE,
    ),
    claim(
        6,
        "GAT is ahead of plain PPO after 2,000 episodes",
        less(Coverage, Between(2000.0, ON), Gat, Plain),
        POSITIVE,
    ),
    claim(6, "GCN ends with more coverage than plain PPO", less(Coverage, End, Gcn, Plain), POSITIVE),
    claim(6, "GAT ends with more coverage than plain PPO", less(Coverage, End, Gat, Plain), POSITIVE),
    claim(6, "GAT and GCN end at a comparable coverage", over(Coverage, End, Gat, Gcn), ALIKE),
    claim(
        6,
        "after 2,000 episodes plain PPO is less stable than GCN",
        less(Coverage, ScatterFrom(2000.0), Plain, Gcn),
        POSITIVE,
    ),
    claim(
        6,
        "after 2,000 episodes plain PPO is less stable than GAT",
        less(Coverage, ScatterFrom(2000.0), Plain, Gat),
        POSITIVE,
    ),
    claim(7, "energy falls during training", all(Energy, Change), NEGATIVE),
    claim(7, "energy goes on falling after 500 episodes", all(Energy, ChangeFrom(500.0)), NEGATIVE),
    claim(7, "most of that fall comes after 500 episodes", all(Energy, GainByLessAfter(500.0)), POSITIVE),
    claim(7, "GCN ends with less energy than plain PPO", less(Energy, End, Gcn, Plain), NEGATIVE),
    claim(7, "GAT ends with less energy than plain PPO", less(Energy, End, Gat, Plain), NEGATIVE),
    claim(
        8,
        "the policy loss is closer to 0 after 2,000 episodes than before",
        all(PolicyLoss, SizeAfterOverBefore(2000.0)),
        Criterion::Below(1.0),
    ),
    claim(9, "a UAV alone covers hardly any PoI at the start", all(Individual, Start), Criterion::Below(1.0)),
    claim(9, "a UAV alone covers 2 PoIs in the end", all(Individual, End), Criterion::Within(1.5, 2.5)),
    claim(9, "this converges by 1,000 episodes", all(Individual, ShareBy(1000.0)), MADE),
    claim(10, "a group covers 10 PoIs after 1,000 episodes", all(Grouped, At(1000.0)), Criterion::Within(9.5, 10.5)),
    claim(10, "that is its peak: at least nine tenths of its change is made", all(Grouped, ShareBy(1000.0)), MADE),
    claim(10, "a group covers 7 PoIs or more in the end", all(Grouped, End), Criterion::Above(7.0)),
    claim(11, "trained policies fly with other numbers of UAVs too", all(Coverage, AboveRandom), POSITIVE),
    claim(11, "GCN covers more than plain PPO", less(Coverage, Flights, Gcn, Plain), POSITIVE),
    claim(11, "GAT covers more than plain PPO", less(Coverage, Flights, Gat, Plain), POSITIVE),
    claim(11, "GCN's lead grows with the number of UAVs", less(Coverage, PerTenUavs, Gcn, Plain), POSITIVE),
    claim(11, "GAT's lead grows with the number of UAVs", less(Coverage, PerTenUavs, Gat, Plain), POSITIVE),
    claim(12, "GCN takes less energy than plain PPO", less(Energy, Flights, Gcn, Plain), NEGATIVE),
    claim(12, "GAT takes less energy than plain PPO", less(Energy, Flights, Gat, Plain), NEGATIVE),
    claim(13, "a UAV alone covers more with GCN than with plain PPO", less(Individual, Flights, Gcn, Plain), POSITIVE),
    claim(13, "a UAV alone covers more with GAT than with plain PPO", less(Individual, Flights, Gat, Plain), POSITIVE),
    claim(13, "it covers less the more UAVs there are", all(Individual, PerTenUavs), NEGATIVE),
    claim(14, "a group covers more the more UAVs there are", all(Grouped, PerTenUavs), POSITIVE),
];

impl Claim {
    /// What the runs say of it.
    #[must_use]
    pub fn test(&self, group: &Group, results: &Results) -> Finding {
        let values = self.measure.values(group, results);
        let interval = student(&values);
        Finding { interval, seeds: values.len(), verdict: judge(interval, self.criterion) }
    }

    /// Decimals for its numbers.
    #[must_use]
    pub const fn decimals(&self) -> usize {
        match self.measure {
            Measure::Relative(..) => 3,
            Measure::Mean(Quantity(_, ShareBy(_) | SizeAfterOverBefore(_))) => 2,
            Measure::Mean(q) | Measure::Spread(q) | Measure::Difference(q, ..) => match q.0 {
                Reward => 1,
                Coverage | Energy | PolicyLoss => 4,
                Individual | Grouped => 2,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::paper::{Curves, Flight, Kind, RunResult, Verdict};
    use covey_env::EpisodeMetrics;

    /// GCN covers 0.1 more than plain PPO, within 0.01 from seed to seed; GAT as much as plain
    /// PPO, now a little more and now a little less.
    fn group() -> Group {
        let mut runs = Vec::new();
        for (graph, more) in [("none", [0.0; 3]), ("gcn", [0.1, 0.11, 0.1]), ("gat", [0.01, -0.01, 0.0])] {
            for (seed, more) in more.into_iter().enumerate() {
                // What seeds share cancels out.
                let coverage = 0.3 + 0.2 * seed as f64 + more;
                let mean = EpisodeMetrics { coverage, ..EpisodeMetrics::default() };
                let flights = vec![Flight { uavs: 20, mean }];
                runs.push(RunResult { graph: graph.into(), seed: seed as u64, curves: Curves::default(), flights });
            }
        }
        Group { kind: Kind::Paper, settings: Vec::new(), runs }
    }

    #[test]
    fn algorithms_are_compared_seed_by_seed() {
        let group = group();
        let results = Results::new(vec![20], 1, 1, Vec::new(), Vec::new());
        let verdict = |one, other, bar| {
            let measure = less(Coverage, Flights, one, other);
            claim(11, "", measure, bar).test(&group, &results).verdict
        };
        assert_eq!(verdict(Gcn, Plain, POSITIVE), Verdict::Holds);
        assert_eq!(verdict(Plain, Gcn, POSITIVE), Verdict::DoesNotHold);
        assert_eq!(verdict(Gat, Plain, POSITIVE), Verdict::NotSeparable);
        let found =
            CLAIMS.iter().find(|c| c.statement == "GCN covers more than plain PPO").unwrap().test(&group, &results);
        assert_eq!((found.seeds, found.verdict), (3, Verdict::Holds));
        assert!((found.interval.unwrap().value - 0.31 / 3.0).abs() < 1e-12);
        // Without flights with several numbers of UAVs there is no slope.
        let lead = CLAIMS.iter().find(|c| c.statement.contains("lead grows")).unwrap();
        assert_eq!(lead.test(&group, &results).verdict, Verdict::NotMeasured);
    }

    #[test]
    fn every_figure_has_claims_and_none_comes_twice() {
        for figure in 5..=14 {
            assert!(CLAIMS.iter().any(|c| c.figure == figure), "figure {figure}");
        }
        for (k, claim) in CLAIMS.iter().enumerate() {
            assert!(CLAIMS[..k].iter().all(|c| c.measure != claim.measure), "{claim:?}");
            assert!(k == 0 || CLAIMS[k - 1].figure <= claim.figure, "{claim:?}");
        }
    }
}
