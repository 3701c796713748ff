//! A made-up episode and made-up curves: the page's looks need no training.

use covey_report::report::{
    Better, Cell, Chart, Column, Content, Episode, Estimate, Figure, Frame, Group, Reference, Report, Row, Section,
    Series, Table,
};

const SIDE_U: f32 = 200.0;
const COVERAGE_RANGE_U: f32 = 10.0;
const COMMUNICATION_RANGE_U: f32 = 18.0;
const SPEED_U: f32 = 4.0;

/// Numbers from 0 to 1 that look random and are always the same.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Roughly normal, mean 0 and deviation 1.
    fn bell(&mut self) -> f32 {
        (0..12).map(|_| self.roll()).sum::<f32>() - 6.0
    }
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// 20 UAVs that drift to the PoIs around them that no other one covers, keep apart
/// while in range, and look for more where there are none.
pub fn episode(title: &str, seed: u64, steps: usize) -> Episode {
    let mut dice = Dice(seed);
    let mut pois = Vec::new();
    for centre in [[52.0, 60.0], [140.0, 62.0], [96.0, 146.0]] {
        pois.extend((0..40).map(|_| [0, 1].map(|k: usize| (centre[k] + 20.0 * dice.bell()).clamp(0.0, SIDE_U))));
    }
    let anywhere = |dice: &mut Dice| [20.0 + 160.0 * dice.roll(), 20.0 + 160.0 * dice.roll()];
    let mut uavs: Vec<[f32; 2]> = (0..20).map(|_| anywhere(&mut dice)).collect();
    let mut velocities = vec![[0.0f32; 2]; uavs.len()];
    let mut waypoints = uavs.clone();
    let mut frames = vec![frame(&uavs, &pois)];
    for _ in 0..steps {
        let before = uavs.clone();
        for (i, &here) in before.iter().enumerate() {
            let others = || before.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, o)| *o);
            let mine =
                |p: &&[f32; 2]| distance(**p, here) <= 15.0 && others().all(|o| distance(o, **p) > COVERAGE_RANGE_U);
            let seen: Vec<_> = pois.iter().filter(mine).collect();
            if seen.is_empty() && distance(here, waypoints[i]) < SPEED_U {
                waypoints[i] = anywhere(&mut dice);
            }
            for k in 0..2 {
                let mut pull = match seen.len() {
                    0 => waypoints[i][k] - here[k],
                    n => seen.iter().map(|p| p[k] - here[k]).sum::<f32>() / n as f32,
                };
                for other in others().filter(|o| distance(*o, here) < COMMUNICATION_RANGE_U) {
                    pull += 0.07 * (here[k] - other[k]);
                }
                velocities[i][k] = 0.6 * velocities[i][k] + 0.2 * pull;
            }
            let speed = velocities[i][0].hypot(velocities[i][1]);
            velocities[i] = velocities[i].map(|v| v * (SPEED_U / speed.max(SPEED_U)));
            uavs[i] = [0, 1].map(|k: usize| (here[k] + velocities[i][k]).clamp(0.0, SIDE_U));
        }
        frames.push(frame(&uavs, &pois));
    }
    Episode {
        title: title.into(),
        side_u: SIDE_U,
        coverage_range_u: COVERAGE_RANGE_U,
        observation_range_u: 13.0,
        communication_range_u: COMMUNICATION_RANGE_U,
        pois,
        action_names: Vec::new(),
        frames,
    }
}

fn frame(uavs: &[[f32; 2]], pois: &[[f32; 2]]) -> Frame {
    let covered: Vec<bool> = pois.iter().map(|p| uavs.iter().any(|u| distance(*u, *p) <= COVERAGE_RANGE_U)).collect();
    let pairs = (0..uavs.len()).flat_map(|i| (i + 1..uavs.len()).map(move |j| (i, j)));
    let edges = pairs.filter(|&(i, j)| distance(uavs[i], uavs[j]) <= COMMUNICATION_RANGE_U);
    Frame {
        uavs: uavs.to_vec(),
        edges: edges.map(|(i, j)| [i as u16, j as u16]).collect(),
        coverage: covered.iter().filter(|c| **c).count() as f32 / pois.len() as f32,
        covered,
        actions: Vec::new(),
    }
}

fn curve(name: &str, seed: u64, (from, to): (f64, f64), noise: f64) -> Series {
    let mut dice = Dice(seed);
    let point = |e: u32| {
        let learnt = 1.0 - (-f64::from(e) / 900.0).exp();
        (f64::from(e), from + (to - from) * learnt + noise * f64::from(dice.bell()))
    };
    let points: Vec<_> = (0..6_000).step_by(4).map(point).collect();
    Series::binned(name, &points, 150)
}

/// Every kind of section.
pub fn report() -> Report {
    let runs = [("PPO + GAT", 1), ("PPO + GCN", 2), ("PPO", 3)];
    let chart = |title: &str, unit: &str, from: f64, to: f64, noise: f64| Chart {
        title: title.into(),
        x_label: "episodes".into(),
        y_label: unit.into(),
        series: runs
            .iter()
            .map(|(name, k)| curve(name, *k, (from, from + (to - from) * (1.06 - 0.06 * *k as f64)), noise))
            .collect(),
        ..Chart::default()
    };
    let mut charts = vec![
        chart("Coverage index", "share of PoIs covered", 0.18, 0.6, 0.03),
        chart("Episodic reward", "per UAV", -20.0, 510.0, 30.0),
        chart("Energy index", "share of full power", 0.9, 0.66, 0.01),
        chart("Individual", "PoIs per UAV", 0.9, 3.1, 0.15),
        chart("Group", "PoIs per UAV", 1.4, 10.5, 0.5),
        chart("Policy loss", "clipped objective", -0.004, -0.018, 0.004),
        chart("Value loss", "normalised", 0.9, 0.12, 0.04),
        chart("Entropy", "nats", 2.83, 1.1, 0.02),
        chart("KL divergence", "nats per update", 0.002, 0.011, 0.001),
    ];
    charts[0].references = vec![
        Reference { name: "centroid heuristic 0.56".into(), y: 0.56 },
        Reference { name: "random 0.15".into(), y: 0.15 },
    ];
    let estimate = |mean, error, decimals| Estimate { mean, standard_error: Some(error), decimals };
    let figure = |label: &str, value, unit: &str, note: &str| Figure {
        label: label.into(),
        value,
        unit: unit.into(),
        note: note.into(),
    };
    let column = |name: &str, better| Column { name: name.into(), unit: String::new(), better };
    let row = |name: &str, emphasis, v: [f64; 6]| Row {
        name: name.into(),
        emphasis,
        cells: vec![
            Cell::Value(estimate(v[0], 0.004, 3)),
            Cell::Value(estimate(v[1], 0.005, 3)),
            Cell::Value(estimate(v[2], 0.002, 2)),
            Cell::Value(estimate(v[3], 0.03, 1)),
            Cell::Value(estimate(v[4], 0.1, 1)),
            Cell::Value(estimate(v[5], 4.2, 0)),
        ],
    };
    let group = |name: &str, entries: &[(&str, &str)]| Group {
        name: name.into(),
        entries: entries.iter().map(|(k, v)| ((*k).into(), (*v).into())).collect(),
    };
    let section = |title: &str, lead: &str, content| Section { title: title.into(), lead: lead.into(), content };
    Report {
        title: "Made-up run: GCN, 20 UAVs".into(),
        subtitle: "Invented figures that show the page. 6,000 episodes, seed 10, clustered PoIs".into(),
        sections: vec![
            section(
                "Key figures",
                "",
                Content::Figures(vec![
                    figure("Coverage index", estimate(0.612, 0.004, 3), "", "200 held-out worlds, int8"),
                    figure("Coverage, last step", estimate(0.668, 0.005, 3), "", ""),
                    figure("Energy index", estimate(0.66, 0.002, 2), "", "share of full power"),
                    figure("Episodic reward", estimate(548.0, 4.2, 0), "", ""),
                    figure("Actor", Estimate::exact(31.4, 1), "KiB", "int8, 17 actions"),
                ]),
            ),
            section(
                "Episodes",
                "Two policies in the same world. Change the episode while it stands at a step to compare them.",
                Content::Episodes(vec![
                    episode("GCN, int8, world 10", 10, 100),
                    episode("GCN, float, world 11", 11, 100),
                ]),
            ),
            section(
                "Learning curves",
                "Mean of each stretch of 40 episodes, ± one standard deviation.",
                Content::Charts(charts),
            ),
            section(
                "Policies",
                "",
                Content::Table(Table {
                    corner: "Policy".into(),
                    columns: vec![
                        column("coverage", Better::Higher),
                        column("last step", Better::Higher),
                        column("energy", Better::Lower),
                        column("individual", Better::Neither),
                        column("group", Better::Neither),
                        column("reward", Better::Higher),
                    ],
                    rows: vec![
                        row("random", false, [0.15, 0.14, 0.91, 0.8, 1.4, 11.0]),
                        row("hover", false, [0.19, 0.19, 0.5, 1.0, 2.0, 100.0]),
                        row("centroid heuristic", false, [0.56, 0.61, 0.69, 3.2, 7.4, 510.0]),
                        row("this run, float", false, [0.613, 0.669, 0.66, 3.1, 10.6, 549.0]),
                        row("this run, int8", true, [0.612, 0.668, 0.66, 3.1, 10.5, 548.0]),
                    ],
                    caption: "Mean of 200 held-out worlds ± standard error.".into(),
                }),
            ),
            section(
                "Configuration",
                "",
                Content::Configuration(vec![
                    group(
                        "Scenario",
                        &[("UAVs", "20"), ("PoIs", "120, clustered"), ("steps", "100"), ("map", "200 × 200 u")],
                    ),
                    group(
                        "Training",
                        &[
                            ("episodes", "6,000"),
                            ("worlds in parallel", "32"),
                            ("learning rate", "5e-4"),
                            ("γ, λ", "0.97, 0.95"),
                        ],
                    ),
                    group("Network", &[("encoder", "106 → 64"), ("aggregation", "GCN"), ("head", "128 → 17")]),
                ]),
            ),
        ],
    }
}
