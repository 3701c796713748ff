//! The int8 actor against the float policy that it was made from.

use covey_env::{BatchedObservation, ObservationForm};
use firmware_core::actor::{
    Actor, Aggregation, CellsActor, Feature, LoadError, Logits, NeighbourFeature, Provenance, QuantisedActor, argmax,
};
use firmware_core::observation::cells::Cells;
use firmware_core::observation::{BuildObservation, Observation};
use host_trainer::eval::UNWATCHED;
use host_trainer::export::{Situation, calibrate, quantise, situation_agreement};
use host_trainer::float_actor::FloatActor;
use host_trainer::settings::Settings;
use host_trainer::train::{Trainer, Workers};

/// Logits of the actor are in this many parts of a nat.
const UNITS_A_NAT: f64 = std::f64::consts::LOG2_E * 256.0;

/// A policy after a few rounds of training.
fn trained(settings: &Settings) -> FloatActor {
    let mut trainer = Trainer::new(settings.clone()).expect("a scenario");
    let workers = Workers::new(2).expect("threads");
    while !trainer.done() {
        trainer.round(&workers).expect("the CPU does not fail");
    }
    FloatActor::new(settings, trainer.state().average.clone())
}

/// The int8 logits of every UAV, each from what it would hear.
fn int8_logits<O: BatchedObservation>(actor: &QuantisedActor<'_, O>, s: &Situation) -> Vec<Logits> {
    let width = usize::from(actor.dimensions().feature);
    let features: Vec<Feature> = O::among(&s.observations).iter().map(|o| actor.encode(o)).collect();
    let degree = |i: usize| s.neighbourhoods[i].count + 1;
    (0..features.len())
        .map(|i| {
            let heard = s.neighbourhoods[i].as_slice().iter().map(|&j| {
                let j = usize::from(j);
                let Feature { values, attention_source, .. } = &features[j];
                NeighbourFeature { values: &values[..width], degree: degree(j), attention_source: *attention_source }
            });
            actor.logits(&features[i], degree(i), heard)
        })
        .collect()
}

/// Agreement of the greatest logits, and how far logits lie apart: root of the mean
/// square, over that of the float logits within a decision.
fn compare<O: BatchedObservation>(actor: &QuantisedActor<'_, O>, situations: &[Situation]) -> (f64, f64) {
    let (mut agreeing, mut all, mut apart, mut spread) = (0, 0, 0.0, 0.0);
    for s in situations {
        for (int8, float) in int8_logits(actor, s).iter().zip(s.logits.chunks_exact(17)) {
            let float: Vec<f64> = float.iter().map(|&l| f64::from(l) * UNITS_A_NAT).collect();
            let mean = float.iter().sum::<f64>() / 17.0;
            apart += float.iter().zip(int8).map(|(f, &i)| (f - f64::from(i)).powi(2)).sum::<f64>();
            spread += float.iter().map(|f| (f - mean).powi(2)).sum::<f64>();
            let first = (0..17).rev().max_by(|&a, &b| float[a].total_cmp(&float[b])).expect("17 logits");
            agreeing += usize::from(usize::from(argmax(int8).index()) == first);
            all += 1;
        }
    }
    assert_eq!(situation_agreement(actor, situations), (agreeing, all), "the trainer counts otherwise");
    (agreeing as f64 / all as f64, (apart / spread).sqrt())
}

/// Share of decisions in which both have the same greatest logit.
fn check(settings: &Settings) -> f64 {
    match settings.observation {
        ObservationForm::Compact => check_as::<Observation>(settings),
        ObservationForm::Cells => check_as::<Cells>(settings),
    }
}

fn check_as<O: BatchedObservation>(settings: &Settings) -> f64 {
    let name = settings.graph.name();
    let float = trained(settings);
    let scenario = settings.world();
    let provenance = Provenance { trainer: "tests", seed: 3, ..Provenance::default() };
    let file = quantise(&float, &scenario, 1, settings.calibration_worlds, provenance, UNWATCHED).expect("quantised");
    let again = quantise(&float, &scenario, 1, settings.calibration_worlds, provenance, UNWATCHED).expect("quantised");
    assert!(file == again, "{name}: quantised twice, two files");
    let actor = QuantisedActor::<O>::load(&file).expect("a sound file");
    actor.self_test().expect("the self-test holds");
    assert_eq!((actor.aggregation(), actor.dimensions()), (float.aggregation, float.dimensions));
    assert_eq!((actor.tie_period(), actor.provenance()), (settings.tie_period, provenance));
    // Worlds that calibration has not seen.
    let (_, situations) = calibrate(&float, &scenario, 2, 4, UNWATCHED).expect("flown");
    let (agreeing, apart) = compare(&actor, &situations);
    println!("{name}: agreement {agreeing:.4}, logits {apart:.4} apart");
    assert!(apart < 0.05, "{name}: logits are {apart:.4} of their spread apart");
    agreeing
}

fn tiny(graph: Aggregation) -> Settings {
    Settings {
        graph,
        uavs: 6,
        pois: 30,
        side: 70.0,
        steps: 20,
        rollout_steps: 10,
        hidden: 16,
        feature: 8,
        head: 16,
        episodes: 64,
        num_envs: 16,
        shards: 2,
        minibatch: 480,
        learning_rate: 3e-3,
        calibration_worlds: 6,
        tie_period: 3,
        ..Settings::default()
    }
}

#[test]
fn small_networks_keep_their_choices_in_int8() {
    // Trained anew, a policy has more or fewer near ties: the mean over four is judged.
    for graph in Aggregation::ALL {
        let agreeing = (1..=4).map(|seed| check(&Settings { seed, ..tiny(graph) })).sum::<f64>() / 4.0;
        assert!(agreeing >= 0.97, "{}: the greatest logits agree in {agreeing:.4} of decisions", graph.name());
    }
}

#[test]
fn networks_on_cells_keep_their_choices_in_int8() {
    for graph in Aggregation::ALL {
        let cells = Settings { observation: ObservationForm::Cells, ..tiny(graph) };
        let agreeing = (1..=4).map(|seed| check(&Settings { seed, ..cells.clone() })).sum::<f64>() / 4.0;
        assert!(agreeing >= 0.97, "{}: the greatest logits agree in {agreeing:.4} of decisions", graph.name());
    }
}

/// Each form's actor refuses the other's file and says why; a damaged file flies nowhere.
#[test]
fn an_actor_of_another_form_is_refused() {
    let file = |observation| {
        let settings = Settings { observation, episodes: 16, hidden: 10, ..tiny(Aggregation::Gcn) };
        quantise(&trained(&settings), &settings.world(), 1, 2, Provenance::default(), UNWATCHED).expect("quantised")
    };
    let (compact, cells) = (file(ObservationForm::Compact), file(ObservationForm::Cells));
    let refused = Actor::load(&cells).expect_err("another form");
    assert_eq!(refused, LoadError::Observation { found: Cells::ID, built: <Observation as BuildObservation>::ID });
    assert!(refused.to_string().contains("wants observation form 100, this program builds form 2"), "{refused}");
    let refused = CellsActor::load(&compact).expect_err("another form");
    assert_eq!(refused, LoadError::Observation { found: <Observation as BuildObservation>::ID, built: Cells::ID });
    assert!(CellsActor::load(&cells).is_ok_and(|actor| actor.self_test().is_ok()));
    for k in (0..cells.len()).step_by(97) {
        let mut damaged = cells.clone();
        damaged[k] ^= 0x40;
        assert!(CellsActor::load(&damaged).is_err() && CellsActor::load(&cells[..k]).is_err(), "byte {k}");
    }
}

/// The network and the swarm of the paper, after a few rounds.
#[test]
fn the_full_network_keeps_its_choices_in_int8() {
    for graph in Aggregation::ALL {
        let paper = Settings { graph, ..Settings::default() };
        let agreeing = check(&Settings { episodes: 16, num_envs: 4, minibatch: 1000, calibration_worlds: 4, ..paper });
        assert!(agreeing >= 0.95, "{}: the greatest logits agree in {agreeing:.4} of decisions", graph.name());
    }
}

/// A temperature divides the logits and nothing else.
#[test]
fn a_temperature_scales_the_exported_logits() {
    let cool = Settings { episodes: 16, temperature: 1.0, ..tiny(Aggregation::Gcn) };
    let warm = Settings { temperature: 2.0, ..cool.clone() };
    let (one, two) = (trained(&cool), trained(&warm));
    let logits =
        |actor: &FloatActor| calibrate(actor, &cool.world(), 2, 1, UNWATCHED).expect("flown").1[0].logits.clone();
    for (a, b) in logits(&one).iter().zip(logits(&two)) {
        assert!((a / 2.0 - b).abs() < 1e-5 * (1.0 + a.abs()), "{a} {b}");
    }
}
