//! The networks against the paper's equations written down in loops, and their gradients
//! against slopes of those.

use covey_env::{Neighbourhood, Observer, PoiDistribution, Scenario, World};
use covey_net::{
    ActorGradient, ActorNet, ActorPass, CriticGradient, CriticNet, CriticPass, Inputs, ParameterLayout, Rows,
    initialise,
};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::actor::{Aggregation, Dimensions};
use firmware_core::observation::{LEN, Observation};

const UAVS: usize = 6;
const DIMENSIONS: Dimensions =
    Dimensions { observation: LEN as u16, hidden: 6, feature: 4, head: 6, actions: ACTIONS as u16 };

/// A pseudo-random number in ±1 for each `k`.
fn noise(k: usize) -> f64 {
    let z = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((z ^ (z >> 29)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Observations and neighbours of the UAVs of two crowded worlds.
fn situations() -> (Vec<Observation>, Vec<Neighbourhood>) {
    let scenario = Scenario { uavs: UAVS, pois: 30, side_u: 40.0, steps: 9, distribution: PoiDistribution::Uniform };
    let mut world = World::new(&scenario).expect("a scenario");
    let (mut observations, mut neighbours) = (vec![[0; LEN]; 2 * UAVS], vec![Neighbourhood::default(); 2 * UAVS]);
    for k in 0..2 {
        world.reset(5, k as u64);
        world.step(&[Action::new(3).expect("an action"); UAVS]);
        let place = k * UAVS..(k + 1) * UAVS;
        Observer::new(9, 1).observe(&world, &mut observations[place.clone()], &mut neighbours[place]);
    }
    let degrees: Vec<u8> = neighbours.iter().map(|n| n.count).collect();
    assert!(
        degrees.contains(&0) && degrees.contains(&3) && degrees.contains(&5),
        "neighbourhoods of all sizes: {degrees:?}"
    );
    (observations, neighbours)
}

/// A fresh network with biases that are not zero and outputs that are not tiny.
fn parameters(layout: &ParameterLayout) -> Vec<f32> {
    let mut values = initialise(layout, "test", 7);
    values.iter_mut().enumerate().for_each(|(k, v)| *v += 0.3 * noise(k) as f32);
    values
}

// --- The networks in loops, f64 -------------------------------------------------------

/// A network's parameters by name.
struct Named<'p> {
    layout: &'p ParameterLayout,
    values: &'p [f64],
}

impl Named<'_> {
    fn block(&self, name: &str) -> &[f64] {
        let p = self.layout.blocks().iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no block {name}"));
        &self.values[p.start..p.start + p.len()]
    }

    /// `x·W`.
    fn times(&self, x: &[f64], weights: &str) -> Vec<f64> {
        let w = self.block(weights);
        let outputs = w.len() / x.len();
        assert_eq!(w.len(), outputs * x.len(), "{weights}");
        (0..outputs).map(|o| x.iter().enumerate().map(|(i, x)| x * w[i * outputs + o]).sum()).collect()
    }

    /// `x·W + b`.
    fn dense(&self, x: &[f64], weights: &str) -> Vec<f64> {
        sum(self.times(x, weights), self.block(&format!("{weights} bias")))
    }

    fn encode(&self, observation: &Observation) -> Vec<f64> {
        let x: Vec<f64> = observation.iter().map(|&o| f64::from(o) / 127.0).collect();
        relu(self.dense(&relu(self.dense(&x, "encoder1")), "encoder2"))
    }
}

fn sum(a: Vec<f64>, b: &[f64]) -> Vec<f64> {
    assert_eq!(a.len(), b.len());
    a.into_iter().zip(b).map(|(a, b)| a + b).collect()
}

fn relu(v: Vec<f64>) -> Vec<f64> {
    v.into_iter().map(|x| x.max(0.0)).collect()
}

/// Row i of the matrix by which features are weighed: `D^(−1/2) A D^(−1/2)` of equation
/// (5), α of equation (6) or of Brody et al., or the mean of the neighbours.
fn weights(
    p: &Named<'_>,
    aggregation: Aggregation,
    h: &[Vec<f64>],
    neighbours: &[Neighbourhood],
    i: usize,
) -> Vec<f64> {
    // A has ones on its diagonal.
    let connected = |i: usize, j: usize| i == j || neighbours[i].as_slice().contains(&(j as u16));
    let degree = |i: usize| (0..h.len()).filter(|&j| connected(i, j)).count() as f64;
    if aggregation == Aggregation::Gcn {
        return (0..h.len())
            .map(|j| if connected(i, j) { 1.0 / (degree(i) * degree(j)).sqrt() } else { 0.0 })
            .collect();
    }
    if aggregation == Aggregation::Sage {
        let n = (degree(i) - 1.0).max(1.0);
        return (0..h.len()).map(|j| if i != j && connected(i, j) { 1.0 / n } else { 0.0 }).collect();
    }
    let leaky = |s: f64| if s < 0.0 { 0.2 * s } else { s };
    let score = |j: usize| {
        if aggregation == Aggregation::GatV2 {
            let x = sum(p.dense(&h[i], "receiver"), &p.dense(&h[j], "sender"));
            return x.into_iter().zip(p.block("attention")).map(|(x, a)| leaky(x) * a).sum();
        }
        let a = [p.block("attention receiver"), p.block("attention sender")].concat();
        let both = [p.times(&h[i], "graph"), p.times(&h[j], "graph")].concat();
        let s: f64 = both.iter().zip(&a).map(|(x, a)| x * a).sum();
        leaky(s)
    };
    let powers: Vec<f64> = (0..h.len()).map(|j| if connected(i, j) { score(j).exp() } else { 0.0 }).collect();
    let total: f64 = powers.iter().sum();
    powers.into_iter().map(|e| e / total).collect()
}

/// Logits of the UAVs of one world.
fn actor(
    p: &Named<'_>,
    aggregation: Aggregation,
    observations: &[Observation],
    neighbours: &[Neighbourhood],
) -> Vec<f64> {
    let h: Vec<Vec<f64>> = observations.iter().map(|o| p.encode(o)).collect();
    let mut logits = Vec::new();
    for (i, own) in h.iter().enumerate() {
        let mut head = p.times(own, "head own");
        if aggregation != Aggregation::None {
            // σ(Σ_j weight_ij·h_j·W): equations (5) and (7).
            let w = if aggregation == Aggregation::GatV2 { "sender" } else { "graph" };
            let mut y = p.block(&format!("{w} bias")).to_vec();
            for (weight, h) in weights(p, aggregation, &h, neighbours, i).into_iter().zip(&h) {
                let part: Vec<f64> = p.times(h, w).into_iter().map(|v| weight * v).collect();
                y = sum(y, &part);
            }
            head = sum(head, &p.times(&relu(y), "head aggregate"));
        }
        logits.extend(p.dense(&relu(sum(head, p.block("head bias"))), "output"));
    }
    logits
}

/// Values of the UAVs of one world.
fn critic(p: &Named<'_>, observations: &[Observation]) -> Vec<f64> {
    let e: Vec<Vec<f64>> = observations.iter().map(|o| p.encode(o)).collect();
    let mean: Vec<f64> = (0..e[0].len()).map(|k| e.iter().map(|e| e[k]).sum::<f64>() / e.len() as f64).collect();
    let shared = sum(p.times(&mean, "head mean"), p.block("head bias"));
    e.iter().flat_map(|own| p.dense(&relu(sum(p.times(own, "head own"), &shared)), "output")).collect()
}

// --- Comparison -----------------------------------------------------------------------

/// A network both ways.
trait Network {
    fn layout(&self) -> ParameterLayout;
    fn in_loops(&self, p: &Named<'_>, observations: &[Observation], neighbours: &[Neighbourhood]) -> Vec<f64>;
    /// Outputs, and the gradient of Σ_k c_k·output_k.
    fn by_hand(&self, values: &[f32], inputs: &Inputs, coefficients: &[f64]) -> (Vec<f32>, Vec<f32>);
}

struct Actor(Aggregation);
struct Critic;

/// The numbers of all rows; then `coefficients` stand there.
fn exchange(rows: &mut Rows, coefficients: &[f64]) -> Vec<f32> {
    let (stride, width) = (rows.stride(), rows.width());
    let mut out = Vec::new();
    for (row, c) in rows.values_mut().chunks_exact_mut(stride).zip(coefficients.chunks_exact(width)) {
        out.extend_from_slice(&row[..width]);
        row.iter_mut().zip(c).for_each(|(r, &c)| *r = c as f32);
    }
    out
}

impl Network for Actor {
    fn layout(&self) -> ParameterLayout {
        ParameterLayout::actor(DIMENSIONS, self.0)
    }
    fn in_loops(&self, p: &Named<'_>, observations: &[Observation], neighbours: &[Neighbourhood]) -> Vec<f64> {
        actor(p, self.0, observations, neighbours)
    }
    fn by_hand(&self, values: &[f32], inputs: &Inputs, coefficients: &[f64]) -> (Vec<f32>, Vec<f32>) {
        let layout = self.layout();
        let mut net = ActorNet::new(&layout, self.0);
        net.load(values);
        let (mut pass, mut sum) = (ActorPass::new(&layout), ActorGradient::new(&layout));
        pass.forward(&net, inputs);
        let out = exchange(pass.logits_mut(), coefficients);
        pass.backward(&net, inputs, &mut sum);
        let mut gradient = vec![f32::NAN; layout.len()];
        sum.store(values, &mut gradient);
        (out, gradient)
    }
}

impl Network for Critic {
    fn layout(&self) -> ParameterLayout {
        ParameterLayout::critic(DIMENSIONS)
    }
    fn in_loops(&self, p: &Named<'_>, observations: &[Observation], _: &[Neighbourhood]) -> Vec<f64> {
        critic(p, observations)
    }
    fn by_hand(&self, values: &[f32], inputs: &Inputs, coefficients: &[f64]) -> (Vec<f32>, Vec<f32>) {
        let layout = self.layout();
        let mut net = CriticNet::new(&layout);
        net.load(values);
        let (mut pass, mut sum) = (CriticPass::new(&layout), CriticGradient::new(&layout));
        pass.forward(&net, inputs);
        let out = exchange(pass.values_mut(), coefficients);
        pass.backward(&net, inputs, &mut sum);
        let mut gradient = vec![f32::NAN; layout.len()];
        sum.store(&mut gradient);
        (out, gradient)
    }
}

/// All worlds, one after the other.
fn in_loops(
    net: &impl Network,
    layout: &ParameterLayout,
    values: &[f64],
    states: &(Vec<Observation>, Vec<Neighbourhood>),
) -> Vec<f64> {
    let worlds = states.0.chunks_exact(UAVS).zip(states.1.chunks_exact(UAVS));
    worlds.flat_map(|(o, l)| net.in_loops(&Named { layout, values }, o, l)).collect()
}

fn check(net: &impl Network) {
    let (layout, states) = (net.layout(), situations());
    let values = parameters(&layout);
    let exact: Vec<f64> = values.iter().map(|&v| v.into()).collect();
    let wanted = in_loops(net, &layout, &exact, &states);
    let scale = wanted.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(scale > 0.1, "a dead network shows nothing");

    let mut inputs = Inputs::new(LEN);
    inputs.clear(UAVS);
    inputs.push(&states.0, &states.1);
    let coefficients: Vec<f64> = (0..wanted.len()).map(|k| noise(1_000_000 + k)).collect();
    let (outputs, slopes) = net.by_hand(&values, &inputs, &coefficients);
    assert_eq!(outputs.len(), wanted.len());
    for (k, (got, want)) in outputs.into_iter().zip(&wanted).enumerate() {
        assert!((f64::from(got) - want).abs() < 2e-6 * (1.0 + scale), "output {k}: {got}, not {want}");
    }

    // The slope of Σ_k c_k·output_k by two steps aside.
    let total = |values: &[f64]| -> f64 {
        in_loops(net, &layout, values, &states).iter().zip(&coefficients).map(|(o, c)| o * c).sum()
    };
    let steepest = slopes.iter().fold(0.0f32, |m, s| m.max(s.abs()));
    let aside = 1e-6;
    for block in layout.blocks() {
        let mut moved = false;
        for k in block.start..block.start + block.len() {
            let mut values = exact.clone();
            values[k] += aside;
            let above = total(&values);
            values[k] -= 2.0 * aside;
            let slope = (above - total(&values)) / (2.0 * aside);
            let error = (slope - f64::from(slopes[k])).abs();
            assert!(error < 1e-5 * f64::from(1.0 + steepest), "{} {k}: {}, not {slope}", block.name, slopes[k]);
            moved |= slope.abs() > 1e-3;
        }
        assert!(moved, "{}: nothing depends on it", block.name);
    }
}

#[test]
fn the_actor_without_a_graph_is_as_written_down() {
    check(&Actor(Aggregation::None));
}

#[test]
fn the_gcn_actor_is_equation_5() {
    check(&Actor(Aggregation::Gcn));
}

#[test]
fn the_gat_actor_is_equations_6_and_7() {
    check(&Actor(Aggregation::Gat));
}

#[test]
fn the_gatv2_actor_scores_as_brody_et_al() {
    check(&Actor(Aggregation::GatV2));
}

#[test]
fn the_sage_actor_takes_the_mean_of_its_neighbours() {
    check(&Actor(Aggregation::Sage));
}

#[test]
fn the_critic_is_as_written_down() {
    check(&Critic);
}
