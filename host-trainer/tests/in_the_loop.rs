//! `eval --actor`: a board flies whole worlds, and what it decides otherwise is found.

#[path = "../../firmware-core/tests/common/mod.rs"]
mod actors;
mod common;

use actors::sample_actor;
use common::{refuse, trainer};
use covey_env::Scenario;
use covey_pil::{Client, Loopback};
use firmware_core::actor::{Actor, Aggregation, Mode};
use host_trainer::eval::pil::{Part, PilEpisode, fly_episode};
use host_trainer::eval::{EvalConfig, EvalPolicy};

/// A dense swarm: more UAVs in range than a board's table holds.
fn config(mode: Mode) -> EvalConfig {
    let scenario = Scenario { uavs: 24, pois: 40, side_u: 60.0, steps: 10, ..Scenario::default() };
    EvalConfig { scenario, seed: 3, worlds: 2, mode }
}

/// World 0 flown by a board in this process that holds `file`, beside `actor`.
fn flown(file: &[u8], actor: &Actor<'_>, config: &EvalConfig, index: u64) -> PilEpisode {
    let mut world = covey_env::World::new(&config.scenario).expect("a world");
    let mut board = Client::new(Loopback::new(file), Loopback::OPTIONS);
    fly_episode(&mut board, actor, config, &mut world, index).expect("the board answers")
}

#[test]
fn a_board_flies_as_this_computer_does() {
    for aggregation in Aggregation::ALL {
        let file = sample_actor(aggregation, 5);
        let actor = Actor::load(&file).expect("an actor");
        for mode in [Mode::Sample, Mode::Argmax] {
            let config = config(mode);
            let worlds = [0, 1].map(|index| flown(&file, &actor, &config, index));
            for world in &worlds {
                assert_eq!((world.decisions, world.differences, world.first), (240, 0, None), "{aggregation:?}");
            }
            let here = EvalPolicy::Int8(&actor).evaluate("", &config).expect("a row");
            let coverage = (worlds[0].metrics.coverage + worlds[1].metrics.coverage) / 2.0;
            assert!((here.coverage - coverage).abs() < 1e-12, "{aggregation:?}: {} and {coverage}", here.coverage);
        }
    }
}

#[test]
fn another_actor_on_the_board_is_found_out() {
    let (file, other) = (sample_actor(Aggregation::Gcn, 5), sample_actor(Aggregation::Gcn, 6));
    let actor = Actor::load(&file).expect("an actor");
    let flown = flown(&other, &actor, &config(Mode::Sample), 1);
    assert_eq!((flown.decisions, flown.differences), (240, 240));
    let first = flown.first.expect("a difference");
    assert_eq!((first.world, first.step, first.uav, first.part), (1, 0, 0, Part::Feature));

    // Without features to compare, the logits tell.
    let (file, other) = (sample_actor(Aggregation::None, 5), sample_actor(Aggregation::None, 6));
    let actor = Actor::load(&file).expect("an actor");
    let flown = self::flown(&other, &actor, &config(Mode::Sample), 0);
    assert_eq!(flown.first.map(|first| first.part), Some(Part::Logits));
}

#[test]
fn a_missing_flight_program_is_named_with_what_builds_it() {
    let words = ["no flight program at", "nowhere.elf", "cargo xtask targets"];
    refuse(trainer().args(["eval", "--actor", "qemu-m7", "--image", "nowhere.elf"]), &words);
}

#[cfg(unix)]
#[test]
fn a_missing_emulator_is_named_with_what_installs_it() {
    let words = ["qemu-system-arm", "cargo xtask setup"];
    let image = env!("CARGO_BIN_EXE_host-trainer");
    refuse(trainer().env("PATH", "").args(["eval", "--actor", "qemu-m4f", "--image", image]), &words);
}

#[test]
fn only_the_actor_flies_on_a_board() {
    for flags in [["--policy", "hover"], ["--run", "x"]] {
        let float: &[&str] = if flags[0] == "--run" { &["--float"] } else { &[] };
        let mut command = trainer();
        command.args(["eval", "--actor", "qemu-m7"]).args(flags).args(float);
        refuse(&mut command, &["cannot be used with"]);
    }
}
