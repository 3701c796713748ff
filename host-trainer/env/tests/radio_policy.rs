//! Worlds flown over a link: over a perfect one as without any, over a bad one by what it
//! brings, always the same.

use covey_env::radio::{
    DECIDE_MS, ENCODE_MS, RadioError, RadioFigures, RadioObserver, RadioPolicy, RadioSettings, evaluate_over,
};
use covey_env::{ActorPolicy, Evaluation, Neighbourhood, Observer, PoiDistribution, Scenario, World, evaluate};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Mode};
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

fn link(text: &str) -> RadioSettings {
    text.parse().expect("a link")
}

/// Flies one world both ways and compares each step; returns the number of links met.
fn assert_same_flight(actor: Actor<'_>, scenario: &Scenario, mode: Mode, link: &RadioSettings, index: u64) -> u64 {
    let mut world = World::new(scenario).expect("a scenario");
    world.reset(SEED, index);
    let mut trained = ActorPolicy::new(actor, SEED, mode);
    let mut flown = RadioPolicy::new(actor, SEED, mode, link, scenario.uavs).expect("a link");
    while !world.done() {
        let step = world.steps_done();
        trained.look(&world);
        flown.look(&world);
        assert_eq!(trained.observations(), flown.observations(), "{link}, step {step}");
        let mut actions = Vec::new();
        for i in 0..scenario.uavs {
            let logits = flown.logits(i, step);
            assert_eq!(trained.logits(i), logits, "{link}, step {step}, UAV {i}");
            actions.push(flown.choose(&logits, i, step));
        }
        world.step(&actions);
    }
    let RadioFigures { neighbours, known, ghosts, .. } = flown.figures();
    assert_eq!((known, ghosts), (neighbours, 0), "{link}");
    neighbours
}

#[test]
fn over_a_perfect_link_it_is_the_policy_without_one() {
    for (name, actor) in actors() {
        for text in ["perfect", "range_u=34"] {
            let half = Scenario { steps: 50, ..Scenario::default() };
            let links = assert_same_flight(actor, &half, Mode::Sample, &link(text), 3);
            assert!(links > 100, "{name}: only {links} links in the episode");
        }
    }
    let short = Scenario { steps: 30, ..Scenario::default() };
    assert_same_flight(gcn(), &short, Mode::Argmax, &link("perfect"), 4);
    for text in ["duplicate=0.5", "delay_ms=400", "jitter_ms=400,duplicate=1"] {
        assert_same_flight(gcn(), &short, Mode::Sample, &link(text), 5);
    }
}

/// More UAVs in reach than a table holds.
#[test]
fn a_dense_swarm_too() {
    let scenario = Scenario { uavs: 70, pois: 60, side_u: 80.0, steps: 15, distribution: PoiDistribution::Uniform };
    for text in ["range_u=34", "perfect"] {
        assert_same_flight(gcn(), &scenario, Mode::Sample, &link(text), 3);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn and_every_swarm(uavs in 1usize..40, side_u in 60.0f32..200.0, seed: u64, reach in 34.0f32..100.0) {
        let scenario = Scenario { uavs, pois: 40, side_u, steps: 12, distribution: PoiDistribution::Clustered };
        let link = RadioSettings { range_u: Some(reach), jitter_ms: 400, ..RadioSettings::default() };
        assert_same_flight(gcn(), &scenario, Mode::Sample, &link, seed);
    }
}

fn flown(link: &RadioSettings, worlds: u64) -> (Evaluation, RadioFigures) {
    let scenario = Scenario { steps: 25, ..Scenario::default() };
    let policy = RadioPolicy::new(gcn(), 0, Mode::Sample, link, scenario.uavs).expect("a link");
    evaluate_over(&scenario, 5, worlds, &policy, |i| i ^ 0x55).expect("a scenario")
}

#[test]
fn an_evaluation_over_a_perfect_link_is_one_without() {
    let scenario = Scenario { steps: 25, ..Scenario::default() };
    let without = evaluate(&scenario, 5, 6, |i| ActorPolicy::new(gcn(), i ^ 0x55, Mode::Sample)).unwrap();
    assert_eq!(flown(&RadioSettings::default(), 6).0, without);
}

#[test]
fn a_policy_of_another_swarm_is_refused() {
    let policy = RadioPolicy::new(gcn(), 0, Mode::Sample, &RadioSettings::default(), 3).unwrap();
    let refused = evaluate_over(&Scenario::default(), 5, 2, &policy, |i| i).unwrap_err();
    assert!(refused.to_string().contains("made for 3 UAVs, the scenario has 20"), "{refused}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let bad = link("loss=0.3,burst=4,delay_ms=300,jitter_ms=2500,duplicate=0.2,reorder=0.1,corrupt=0.1,range_u=60");
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
fn a_silent_link_leaves_everyone_alone() {
    let (_, figures) = flown(&link("loss=1"), 2);
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
    let bad = link("loss=0.4,jitter_ms=3000,reorder=0.2");
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

/// Observations and links of an episode, seen by `observe`, with random actions.
fn seen(
    mut observe: impl FnMut(&World, &mut [[i8; LEN]], &mut [Neighbourhood]),
) -> Vec<(Vec<[i8; LEN]>, Vec<Neighbourhood>)> {
    let scenario = Scenario { steps: 25, ..Scenario::default() };
    let mut world = World::new(&scenario).unwrap();
    world.reset(3, 3);
    let mut all = Vec::new();
    while !world.done() {
        let (mut out, mut links) = (vec![[0; LEN]; scenario.uavs], vec![Neighbourhood::default(); scenario.uavs]);
        observe(&world, &mut out, &mut links);
        all.push((out, links));
        let step = world.steps_done() as usize;
        let action = |i: usize| Action::new(((7 * i + step * step) % 17) as u8).unwrap();
        world.step(&(0..scenario.uavs).map(action).collect::<Vec<_>>());
    }
    all
}

/// What training sees over a link is what the int8 policy sees over it, whatever its features.
#[test]
fn training_sees_what_flies() {
    let mut without = Observer::new(9, 2);
    let mut over = RadioObserver::new(20).unwrap();
    over.begin(9, 2, &link("range_u=34")).unwrap();
    assert_eq!(seen(|w, out, links| without.observe(w, out, links)), seen(|w, out, links| over.observe(w, out, links)));
    let bad = link("loss=0.3,delay_ms=2000,range_u=34");
    let mut policy = RadioPolicy::new(gcn(), 9, Mode::Sample, &bad, 20).unwrap();
    let flown = seen(|w, out, _| {
        policy.look(w);
        out.copy_from_slice(policy.observations());
    });
    // The same draws and tie-breakers, although the link was another before.
    over.begin(9, gcn().tie_period(), &bad).unwrap();
    let trained = seen(|w, out, links| over.observe(w, out, links));
    let (_, linked): (Vec<_>, Vec<_>) = trained.iter().cloned().unzip();
    assert!(linked.iter().flatten().any(|l| l.count > 0));
    for (step, ((flown, _), (trained, _))) in flown.iter().zip(&trained).enumerate() {
        assert_eq!(flown, trained, "step {step}");
    }
    let features: usize = linked.iter().flatten().map(|l| usize::from(l.count)).sum();
    assert_eq!(features as u64, policy.figures().features);
}

#[test]
fn an_observer_refuses_what_cannot_be() {
    assert_eq!(RadioObserver::new(0).unwrap_err(), RadioError::Nodes(0));
    let mut over = RadioObserver::new(2).unwrap();
    let bad = RadioSettings { loss: 2.0, ..RadioSettings::default() };
    assert_eq!(over.begin(1, 1, &bad), Err(RadioError::Share { key: "loss", value: 2.0 }));
}
