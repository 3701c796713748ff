//! Training with the networks in burn, here on its CPU device, beside those written by hand.

mod common;

use common::{refuse, trainer};
use covey_burn::{BurnEngine, Kind};
use covey_env::ObservationForm;
use covey_net::{ActorCritic, Engine, EngineError, GraphBatch, Outputs};
use firmware_core::actor::Aggregation;
use host_trainer::settings::Settings;
use host_trainer::train::{RoundMetrics, Trainer, Workers};

fn settings(graph: Aggregation) -> Settings {
    Settings {
        graph,
        // More than 32: two words of neighbours.
        uavs: 35,
        uavs_max: 0,
        pois: 60,
        side: 150.0,
        steps: 20,
        rollout_steps: 10,
        hidden: 32,
        feature: 16,
        head: 32,
        num_envs: 6,
        shards: 3,
        episodes: 24,
        minibatch: 700,
        epochs: 2,
        cloning_weight: 0.5,
        cloning_episodes: 12,
        ..Settings::default()
    }
}

fn engine(trainer: &Trainer) -> Box<dyn Engine> {
    let aggregation = trainer.settings().graph;
    Box::new(BurnEngine::open(Kind::Flex, trainer.layouts().clone(), aggregation).expect("a CPU"))
}

/// Metrics of a whole run, and the actor at its end.
fn run(mut trainer: Trainer) -> (Vec<RoundMetrics>, Vec<f32>) {
    let workers = Workers::new(2).expect("threads");
    let mut rows = Vec::new();
    while !trainer.done() {
        rows.push(trainer.round(&workers).expect("a round"));
    }
    (rows, trainer.state().actor.clone())
}

/// The same run but for the last digits: sums come out in another order.
fn trains_alike(graph: Aggregation) {
    let fresh = || Trainer::new(settings(graph)).expect("a scenario");
    let (by_hand, actor) = run(fresh());
    let start = fresh().state().actor.clone();
    let on_burn = fresh();
    let engine = engine(&on_burn);
    let (rows, burn_actor) = run(on_burn.on(engine).expect("the same numbers"));
    assert_eq!((by_hand.len(), rows.len()), (4, 4));
    for (a, b) in by_hand.iter().zip(&rows) {
        println!("{a:?}\n{b:?}");
        for ((name, a), (_, b)) in a.curves().iter().zip(b.curves()) {
            assert!((a - b).abs() < 1e-3 * a.abs().max(0.1), "{name}: {a} by hand, {b} in burn");
        }
    }
    let distance = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
    let (moved, apart) = (distance(&start, &actor), distance(&actor, &burn_actor));
    println!("moved {moved}, apart {apart}");
    assert!(moved > 0.1 && apart < 0.01 * moved, "the actors moved {moved} and are {apart} apart");
}

#[test]
fn training_without_a_graph_is_alike_on_burn() {
    trains_alike(Aggregation::None);
}

#[test]
fn training_gcn_is_alike_on_burn() {
    trains_alike(Aggregation::Gcn);
}

#[test]
fn training_gat_is_alike_on_burn() {
    trains_alike(Aggregation::Gat);
}

#[test]
fn training_gatv2_is_alike_on_burn() {
    trains_alike(Aggregation::GatV2);
}

#[test]
fn training_sage_is_alike_on_burn() {
    trains_alike(Aggregation::Sage);
}

/// A device whose driver is wrong or that gives up.
struct Broken {
    inner: Box<dyn Engine>,
    spoil: fn(&mut Outputs, &mut ActorCritic<Vec<f32>>) -> Result<(), EngineError>,
}

impl Engine for Broken {
    fn name(&self) -> String {
        "broken".to_owned()
    }

    fn load_parameters(&mut self, parameters: ActorCritic<&[f32]>) {
        self.inner.load_parameters(parameters);
    }

    fn forward(&mut self, batches: &[GraphBatch<'_>], out: &mut Outputs) -> Result<(), EngineError> {
        self.inner.forward(batches, out)?;
        (self.spoil)(out, &mut ActorCritic::default())
    }

    fn load_rollout(&mut self, batches: &[GraphBatch<'_>]) {
        self.inner.load_rollout(batches);
    }

    fn gradient(
        &mut self,
        world_steps: &[u32],
        out: &mut Outputs,
        loss: &mut dyn FnMut(&mut Outputs),
        gradients: &mut ActorCritic<Vec<f32>>,
    ) -> Result<(), EngineError> {
        self.inner.gradient(world_steps, out, loss, gradients)?;
        (self.spoil)(&mut Outputs::default(), gradients)
    }
}

#[test]
fn a_device_with_wrong_numbers_does_not_train() {
    let refusal = |spoil| {
        let trainer = Trainer::new(settings(Aggregation::Gcn)).expect("a scenario");
        let inner = engine(&trainer);
        trainer.on(Box::new(Broken { inner, spoil })).err().map(|e| e.to_string())
    };
    assert_eq!(refusal(|_, _| Ok(())), None);
    for (word, spoil) in [
        (
            "logits",
            (|out, _| {
                out.logits.values_mut().iter_mut().for_each(|l| *l *= 1.1);
                Ok(())
            }) as fn(&mut Outputs, &mut ActorCritic<Vec<f32>>) -> _,
        ),
        ("values", |out, _| {
            // One among many, and not the last.
            out.values.values_mut()[0] = f32::NAN;
            Ok(())
        }),
        ("actor's gradient", |_, g| {
            g.actor.reverse();
            Ok(())
        }),
        ("critic's gradient", |_, g| {
            g.critic.pop();
            Ok(())
        }),
        ("memory is full", |_, _| {
            Err(EngineError::Failed { device: "broken".to_owned(), why: "memory is full".to_owned() })
        }),
    ] {
        let message = refusal(spoil).unwrap_or_else(|| panic!("{word}: accepted"));
        assert!(message.contains(word) && message.contains("broken"), "{word}: {message}");
    }
}

#[test]
fn runs_that_no_device_computes_are_refused() {
    let usual = || settings(Aggregation::Gcn);
    for (settings, setting) in [
        (Settings { observation: ObservationForm::Cells, cloning_weight: 0.0, ..usual() }, "observation = \"compact\""),
        (Settings { uavs_max: 40, ..usual() }, "uavs_max = 0"),
    ] {
        let trainer = Trainer::new(settings).expect("a scenario");
        let engine = engine(&trainer);
        let message = trainer.on(engine).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(setting) && message.contains("--device cpu"), "{setting}: {message:?}");
    }
}

#[test]
fn a_program_without_the_device_says_how_to_build_it() {
    let folder = tempfile::tempdir().expect("a folder");
    for device in ["cuda", "wgpu"] {
        if cfg!(feature = "cuda") || cfg!(feature = "wgpu") {
            continue;
        }
        let words = ["built without", &format!("--features {device}")];
        refuse(trainer().args(["bench", "--device", device]), &words);
        let run = folder.path().join(device);
        refuse(trainer().args(["train", "--device", device, "--out"]).arg(&run), &words);
        assert!(!run.exists(), "a run folder for nothing");
    }
}
