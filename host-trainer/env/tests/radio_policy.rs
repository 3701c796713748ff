//! Swarms over a radio channel: over a perfect one as without any, over a bad one by what it delivers, reproducibly.

use covey_env::radio::{
    DECIDE_MS, ENCODE_MS, RadioError, RadioFigures, RadioObserver, RadioPolicy, RadioSettings, evaluate_over_radio,
};
use covey_env::{ActorPolicy, Evaluation, Neighbourhood, Observer, PoiDistribution, Scenario, World, evaluate};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Mode};
use firmware_core::agent::Decision;
use firmware_core::observation::LEN;
use proptest::prelude::*;
use std::path::Path;
use std::sync::LazyLock;

const SEED: u64 = 41;
const KINDS: [&str; 3] = ["sample-none", "sample-gcn", "sample-gat"];

static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../firmware-core/tests/data");
    let file = |name| std::fs::read(folder.join(format!("{name}.actor"))).expect("a committed sample actor");
    KINDS.map(file).to_vec()
});

fn actors() -> impl Iterator<Item = (&'static str, Actor<'static>)> {
    KINDS.into_iter().zip(FILES.iter()).map(|(name, file)| (name, Actor::load(file).expect("sound")))
}

fn gcn() -> Actor<'static> {
    Actor::load(&FILES[1]).expect("sound")
}

fn radio(text: &str) -> RadioSettings {
    text.parse().expect("valid settings")
}

/// Flies one world both ways and compares each step; returns the number of edges of the graph met.
fn assert_same_flight(actor: Actor<'_>, scenario: &Scenario, mode: Mode, settings: &RadioSettings, index: u64) -> u64 {
    let mut world = World::new(scenario).expect("a scenario");
    world.reset(SEED, index);
    let mut without = ActorPolicy::new(actor, SEED, mode);
    let mut over = RadioPolicy::new(actor, SEED, mode, settings, scenario.uavs).expect("valid settings");
    while !world.done() {
        let step = world.steps_done();
        without.observe(&world);
        over.observe(&world);
        assert_eq!(without.observations(), over.observations(), "{settings}, step {step}");
        let mut actions = Vec::new();
        for i in 0..scenario.uavs {
            let Decision { action, logits, .. } = over.decide(i);
            assert_eq!(without.logits(i), logits, "{settings}, step {step}, UAV {i}");
            assert_eq!(without.choose(&logits, i, step), action, "{settings}, step {step}, UAV {i}");
            actions.push(action);
        }
        world.step(&actions);
    }
    let RadioFigures { neighbours, known, ghosts, .. } = over.figures();
    assert_eq!((known, ghosts), (neighbours, 0), "{settings}");
    neighbours
}

#[test]
fn over_a_perfect_radio_it_equals_the_policy_without_one() {
    for (name, actor) in actors() {
        for text in ["perfect", "range_u=34"] {
            let half = Scenario { steps: 50, ..Scenario::default() };
            let edges = assert_same_flight(actor, &half, Mode::Sample, &radio(text), 3);
            assert!(edges > 100, "{name}: only {edges} edges in the episode");
        }
    }
    let short = Scenario { steps: 30, ..Scenario::default() };
    assert_same_flight(gcn(), &short, Mode::Argmax, &radio("perfect"), 4);
    for text in ["duplicate=0.5", "delay_ms=400", "jitter_ms=400,duplicate=1"] {
        assert_same_flight(gcn(), &short, Mode::Sample, &radio(text), 5);
    }
}

/// More UAVs in reach than a table holds.
#[test]
fn a_dense_swarm_too() {
    let scenario = Scenario { uavs: 70, pois: 60, side_u: 80.0, steps: 15, distribution: PoiDistribution::Uniform };
    for text in ["range_u=34", "perfect"] {
        assert_same_flight(gcn(), &scenario, Mode::Sample, &radio(text), 3);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn and_every_swarm(uavs in 1usize..40, side_u in 60.0f32..200.0, seed: u64, reach in 34.0f32..100.0) {
        let scenario = Scenario { uavs, pois: 40, side_u, steps: 12, distribution: PoiDistribution::Clustered };
        let settings = RadioSettings { range_u: Some(reach), jitter_ms: 400, ..RadioSettings::default() };
        assert_same_flight(gcn(), &scenario, Mode::Sample, &settings, seed);
    }
}

fn flown(settings: &RadioSettings, worlds: u64) -> (Evaluation, RadioFigures) {
    let scenario = Scenario { steps: 25, ..Scenario::default() };
    let policy = RadioPolicy::new(gcn(), 0, Mode::Sample, settings, scenario.uavs).expect("valid settings");
    evaluate_over_radio(&scenario, 5, worlds, &policy, |i| i ^ 0x55, |_| ()).expect("a scenario")
}

#[test]
fn an_evaluation_over_a_perfect_radio_equals_one_without() {
    let scenario = Scenario { steps: 25, ..Scenario::default() };
    let without = evaluate(&scenario, 5, 6, |i| ActorPolicy::new(gcn(), i ^ 0x55, Mode::Sample)).unwrap();
    assert_eq!(flown(&RadioSettings::default(), 6).0, without);
}

#[test]
fn a_policy_of_another_swarm_is_refused() {
    let policy = RadioPolicy::new(gcn(), 0, Mode::Sample, &RadioSettings::default(), 3).unwrap();
    let refused = evaluate_over_radio(&Scenario::default(), 5, 2, &policy, |i| i, |_| ()).unwrap_err();
    assert!(refused.to_string().contains("made for 3 UAVs, the scenario has 20"), "{refused}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let bad = radio("loss=0.3,burst=4,delay_ms=300,jitter_ms=2500,duplicate=0.2,reorder=0.1,corrupt=0.1,range_u=60");
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| flown(&bad, 7))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(3));
    assert!(one.1.known < one.1.neighbours && one.1.malformed > 0 && one.1.refused > 0, "{:?}", one.1);
}

#[test]
fn over_a_silent_radio_nobody_knows_of_anybody() {
    let (_, figures) = flown(&radio("loss=1"), 2);
    assert_eq!((figures.known, figures.ghosts, figures.features, figures.taken), (0, 0, 0, 0));
    assert!(figures.neighbours > 0);
    assert_eq!(figures.counts.lost, figures.counts.sent);
}

/// Known in its own step, one step later, two steps later, or never: up to the limits of the
/// neighbour table.
#[test]
fn a_delay_makes_neighbours_late_and_then_unknown() {
    let share = |delay_ms: u64| {
        let (_, f) = flown(&RadioSettings { delay_ms: delay_ms as u32, ..RadioSettings::default() }, 3);
        (f.known as f64 / f.neighbours as f64, f.features as f64 / f.neighbours as f64, f.ghosts)
    };
    assert_eq!(share(ENCODE_MS), (1.0, 1.0, 0));
    // Features have DECIDE_MS − ENCODE_MS, which is as much.
    assert_eq!(DECIDE_MS - ENCODE_MS, ENCODE_MS);
    let mut before = 1.0;
    for delay_ms in [ENCODE_MS + 1, 4_000] {
        let (known, _, ghosts) = share(delay_ms);
        assert!(known < before && known > 0.5 && ghosts > 0, "{delay_ms} ms: {known} known, {ghosts} ghosts");
        before = known;
    }
    assert_eq!(share(4_000 + ENCODE_MS + 1), (0.0, 0.0, 0));
}

/// A policy that begins again is as good as new.
#[test]
fn an_episode_leaves_nothing_for_the_next() {
    let scenario = Scenario { steps: 15, ..Scenario::default() };
    let bad = radio("loss=0.4,jitter_ms=3000,reorder=0.2");
    let mut world = World::new(&scenario).unwrap();
    let mut policy = RadioPolicy::new(gcn(), 9, Mode::Sample, &bad, scenario.uavs).unwrap();
    let mut fly = || {
        use covey_env::Policy;
        world.reset(3, 3);
        let mut actions = vec![Action::COAST; scenario.uavs];
        policy.begin(&world);
        while !world.done() {
            policy.act(&world, &mut actions);
            world.step(&actions);
        }
        (world.metrics(), policy.figures())
    };
    assert_eq!(fly(), fly());
}

/// Observations and neighbourhoods of an episode, as `observe` writes them, with pseudo-random actions.
fn observed(
    mut observe: impl FnMut(&World, &mut [[i8; LEN]], &mut [Neighbourhood]),
) -> Vec<(Vec<[i8; LEN]>, Vec<Neighbourhood>)> {
    let scenario = Scenario { steps: 25, ..Scenario::default() };
    let mut world = World::new(&scenario).unwrap();
    world.reset(3, 3);
    let mut all = Vec::new();
    while !world.done() {
        let (mut observations, mut neighbourhoods) =
            (vec![[0; LEN]; scenario.uavs], vec![Neighbourhood::default(); scenario.uavs]);
        observe(&world, &mut observations, &mut neighbourhoods);
        all.push((observations, neighbourhoods));
        let step = world.steps_done() as usize;
        let action = |i: usize| Action::new(((7 * i + step * step) % 17) as u8).unwrap();
        world.step(&(0..scenario.uavs).map(action).collect::<Vec<_>>());
    }
    all
}

/// Over a radio channel training observes what the int8 policy observes, whatever its features.
#[test]
fn training_observes_what_flies() {
    let mut without = Observer::new(9, 2);
    let mut over = RadioObserver::new(20).unwrap();
    over.begin(9, 2, &radio("range_u=34")).unwrap();
    assert_eq!(observed(|w, o, n| without.observe(w, o, n)), observed(|w, o, n| over.observe(w, o, n)));
    let bad = radio("loss=0.3,delay_ms=2000,range_u=34");
    let mut policy = RadioPolicy::new(gcn(), 9, Mode::Sample, &bad, 20).unwrap();
    let flown = observed(|w, o, _| {
        policy.observe(w);
        o.copy_from_slice(policy.observations());
    });
    // The same draws and tie-breakers, although the settings were others before.
    over.begin(9, gcn().tie_period(), &bad).unwrap();
    let trained = observed(|w, o, n| over.observe(w, o, n));
    let (_, neighbourhoods): (Vec<_>, Vec<_>) = trained.iter().cloned().unzip();
    assert!(neighbourhoods.iter().flatten().any(|n| n.count > 0));
    for (step, ((flown, _), (trained, _))) in flown.iter().zip(&trained).enumerate() {
        assert_eq!(flown, trained, "step {step}");
    }
    let features: usize = neighbourhoods.iter().flatten().map(|n| usize::from(n.count)).sum();
    assert_eq!(features as u64, policy.figures().features);
}

#[test]
fn an_observer_refuses_settings_out_of_range() {
    assert_eq!(RadioObserver::new(0).unwrap_err(), RadioError::Nodes(0));
    let mut over = RadioObserver::new(2).unwrap();
    let bad = RadioSettings { loss: 2.0, ..RadioSettings::default() };
    assert_eq!(over.begin(1, 1, &bad), Err(RadioError::Probability { key: "loss", value: 2.0 }));
}
