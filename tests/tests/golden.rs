//! Whole episodes computed by an independent implementation, followed step by step.
//!
//! Reads every `*.json` in the folder named by `GOLDEN_DIR`, or in `golden/` beside
//! this package. A file holds `side`, `n_uav`, `uav` and `poi` (positions at reset, u),
//! `actions[step][uav]` and `steps[step]`, the state after that action. Other keys are
//! notes of whoever wrote the file and are passed over.

use covey_env::{Scenario, World};
use firmware_core::action::Action;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Positions, velocities, rewards and energies agree within this.
const TOLERANCE: f64 = 1e-3;

#[derive(Deserialize)]
struct Episode {
    side: f32,
    n_uav: usize,
    uav: Vec<(f32, f32)>,
    poi: Vec<(f32, f32)>,
    actions: Vec<Vec<u8>>,
    steps: Vec<Step>,
}

#[derive(Deserialize)]
struct Step {
    pos: Vec<(f64, f64)>,
    vel: Vec<(f64, f64)>,
    degree: Vec<u32>,
    group_size: Vec<u32>,
    individual: Vec<u32>,
    group: Vec<u32>,
    near_border: Vec<bool>,
    energy: Vec<f64>,
    reward: Vec<f64>,
    covered: usize,
}

fn folder() -> PathBuf {
    std::env::var_os("GOLDEN_DIR").map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("golden"), PathBuf::from)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("golden folder {}: {e}", folder.display()));
    let mut files: Vec<_> = entries
        .map(|e| e.expect("folder entry").path())
        .filter(|p| p.extension().is_some_and(|e| e == "json"))
        .collect();
    files.sort();
    files
}

fn parse(text: &str) -> serde_json::Result<Episode> {
    serde_json::from_str(text)
}

fn read(file: &Path) -> Episode {
    let name = file.display();
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{name}: {e}"));
    let episode = parse(&text).unwrap_or_else(|e| panic!("{name}: not a golden episode: {e}"));
    let n = episode.n_uav;
    assert_eq!(episode.uav.len(), n, "{name}: uav has not n_uav entries");
    assert!(!episode.steps.is_empty(), "{name}: steps is empty");
    assert_eq!(episode.actions.len(), episode.steps.len(), "{name}: actions and steps differ in length");
    for (t, (actions, step)) in episode.actions.iter().zip(&episode.steps).enumerate() {
        let sizes = [
            ("actions", actions.len()),
            ("pos", step.pos.len()),
            ("vel", step.vel.len()),
            ("degree", step.degree.len()),
            ("group_size", step.group_size.len()),
            ("individual", step.individual.len()),
            ("group", step.group.len()),
            ("near_border", step.near_border.len()),
            ("energy", step.energy.len()),
            ("reward", step.reward.len()),
        ];
        for (key, len) in sizes {
            assert_eq!(len, n, "{name}: step {t}: {key} has not n_uav entries");
        }
    }
    episode
}

fn replay(file: &Path) {
    let name = file.display();
    let episode = read(file);
    let scenario = Scenario {
        uavs: episode.n_uav,
        pois: episode.poi.len(),
        side_u: episode.side,
        steps: episode.steps.len() as u32,
        ..Scenario::default()
    };
    let mut world = World::new(&scenario).unwrap_or_else(|e| panic!("{name}: {e}"));
    world.set_positions(&episode.uav, &episode.poi).unwrap_or_else(|e| panic!("{name}: {e}"));
    for (t, (actions, want)) in episode.actions.iter().zip(&episode.steps).enumerate() {
        let action = |&k: &u8| Action::new(k).unwrap_or_else(|| panic!("{name}: step {t}: no action {k}"));
        let actions: Vec<_> = actions.iter().map(action).collect();
        world.step(&actions);
        for i in 0..scenario.uavs {
            let at = |what: &str| format!("{name}: step {t}, UAV {i}: {what}");
            let close = |what: &str, got: f32, want: f64| {
                assert!((f64::from(got) - want).abs() <= TOLERANCE, "{}: {got}, not {want}", at(what));
            };
            close("x", world.x()[i], want.pos[i].0);
            close("y", world.y()[i], want.pos[i].1);
            close("vx", world.vx()[i], want.vel[i].0);
            close("vy", world.vy()[i], want.vel[i].1);
            assert_eq!(world.degree()[i], want.degree[i], "{}", at("degree"));
            assert_eq!(world.group_size()[i], want.group_size[i], "{}", at("group_size"));
            assert_eq!(world.individual()[i], want.individual[i], "{}", at("individual"));
            assert_eq!(world.group()[i], want.group[i], "{}", at("group"));
            assert_eq!(world.near_border()[i], want.near_border[i], "{}", at("near_border"));
            close("energy", world.energy()[i], want.energy[i]);
            close("reward", world.rewards()[i], want.reward[i]);
        }
        assert_eq!(world.covered(), want.covered, "{name}: step {t}: covered");
    }
    assert!(world.done(), "{name}: the episode is over");
}

#[test]
fn golden_episodes_are_followed_step_by_step() {
    let folder = folder();
    let files = files(&folder);
    assert!(!files.is_empty(), "no *.json in {}; set GOLDEN_DIR to a folder of golden episodes", folder.display());
    for file in &files {
        replay(file);
    }
}

/// One UAV that hovers for a step.
const SHORT: &str = r#"{
    "side": 200, "n_uav": 1, "uav": [[50, 60]], "poi": [[52, 60]], "actions": [[16]], "made_by": "someone",
    "steps": [{
        "pos": [[50, 60]], "vel": [[0, 0]], "degree": [0], "group_size": [1], "individual": [1], "group": [1],
        "near_border": [false], "energy": [0.5], "reward": [2], "covered": 1, "comment": {"any": "thing"}
    }]
}"#;

#[test]
fn keys_beyond_the_episode_are_passed_over() {
    let episode = parse(SHORT).expect("an episode with two more keys");
    assert_eq!((episode.n_uav, episode.steps[0].covered), (1, 1));
}

#[test]
fn a_key_that_is_missing_or_of_another_type_is_named() {
    let refusal = |from: &str, to: &str| {
        let text = SHORT.replace(from, to);
        assert_ne!(text, SHORT);
        parse(&text).err().expect("refused").to_string()
    };
    assert!(refusal("\"reward\"", "\"rewards\"").contains("reward"));
    assert!(refusal("\"n_uav\"", "\"n\"").contains("n_uav"));
    assert!(refusal("[false]", "[0]").contains("boolean"));
}
