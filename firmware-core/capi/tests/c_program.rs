//! Compiles a C program against the header and the static library, runs it, and compares
//! what it prints with what the same calls give in Rust.

#[path = "../../tests/common/mod.rs"]
mod common;

use common::sample_actor;
use covey_capi::{
    CoveyDecision, CoveyFeature, CoveyNeighbour, CoveyNeighbourFeature, CoveyScene, CoveyVec2, CoveyView, Status,
};
use firmware_core::action::ACTIONS;
use firmware_core::actor::{Actor, Aggregation, Mode, NeighbourFeature, signature};
use firmware_core::geometry::{State, TICKS_PER_U, Vec2};
use firmware_core::observation::{LEN, MAX_NEIGHBOURS, Neighbour, Neighbours, Scene, observe};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::process::Command;

const HEADER: &str = include_str!("../include/covey.h");
const SEED: u64 = 10;
const ID: u16 = 7;
const STEP: u32 = 5;

/// Cargo builds the static library together with the one that this test links, beside the
/// test's own binary. Older builds may lie there too: the newest is of the present code.
fn library() -> PathBuf {
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let entries = std::fs::read_dir(&deps).unwrap().map(|entry| entry.unwrap());
    let is_library = |name: &str| name.starts_with("libcovey_capi") && name.ends_with(".a");
    entries
        .filter(|entry| is_library(&entry.file_name().to_string_lossy()))
        .max_by_key(|entry| entry.metadata().unwrap().modified().unwrap())
        .unwrap_or_else(|| panic!("no static library in {}", deps.display()))
        .path()
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    assert!(output.status.success(), "{command:?}\n{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn compiler() -> Command {
    Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()))
}

fn expected_layout() -> String {
    let mut out = String::new();
    let mut line = |name: &str, value: usize| writeln!(out, "{name} {value}").unwrap();
    line("sizeof(covey_actor)", 8 * (8 + 8 * size_of::<*const u8>()));
    line("sizeof(covey_vec2)", size_of::<CoveyVec2>());
    line("sizeof(covey_neighbour)", size_of::<CoveyNeighbour>());
    line("covey_neighbour.velocity", offset_of!(CoveyNeighbour, velocity));
    line("covey_neighbour.id", offset_of!(CoveyNeighbour, id));
    line("covey_neighbour.tie", offset_of!(CoveyNeighbour, tie));
    line("sizeof(covey_scene)", size_of::<CoveyScene>());
    line("covey_scene.velocity", offset_of!(CoveyScene, velocity));
    line("covey_scene.half_side", offset_of!(CoveyScene, half_side));
    line("covey_scene.id", offset_of!(CoveyScene, id));
    line("covey_scene.tie", offset_of!(CoveyScene, tie));
    line("covey_scene.neighbours", offset_of!(CoveyScene, neighbours));
    line("covey_scene.neighbour_count", offset_of!(CoveyScene, neighbour_count));
    line("covey_scene.pois", offset_of!(CoveyScene, pois));
    line("covey_scene.poi_count", offset_of!(CoveyScene, poi_count));
    line("sizeof(covey_view)", size_of::<CoveyView>());
    line("covey_view.degree", offset_of!(CoveyView, degree));
    line("covey_view.kept", offset_of!(CoveyView, kept));
    line("sizeof(covey_feature)", size_of::<CoveyFeature>());
    line("covey_feature.attending", offset_of!(CoveyFeature, attending));
    line("covey_feature.attended", offset_of!(CoveyFeature, attended));
    line("sizeof(covey_neighbour_feature)", size_of::<CoveyNeighbourFeature>());
    line("covey_neighbour_feature.degree", offset_of!(CoveyNeighbourFeature, degree));
    line("covey_neighbour_feature.attended", offset_of!(CoveyNeighbourFeature, attended));
    line("sizeof(covey_decision)", size_of::<CoveyDecision>());
    line("covey_decision.action", offset_of!(CoveyDecision, action));
    line("COVEY_OBSERVATION", LEN);
    line("COVEY_FEATURE", firmware_core::actor::MAX_FEATURE);
    line("COVEY_NEIGHBOURS", MAX_NEIGHBOURS);
    line("COVEY_ACTIONS", ACTIONS);
    line("COVEY_TICKS_PER_U", TICKS_PER_U as usize);
    for (status, _) in Status::ALL {
        // OutOfRange is COVEY_OUT_OF_RANGE.
        let name: String = format!("{status:?}")
            .chars()
            .flat_map(|c| if c.is_uppercase() { vec!['_', c] } else { vec![c.to_ascii_uppercase()] })
            .collect();
        line(&format!("COVEY{name}"), status as usize);
    }
    line("COVEY_SAMPLE", 0);
    line("COVEY_ARGMAX", 1);
    out
}

fn numbers<T: std::fmt::Display>(items: impl IntoIterator<Item = T>) -> String {
    items.into_iter().map(|i| format!(" {i}")).collect()
}

/// What `flight.c` must print after the layout.
fn expected_flight(file: &[u8]) -> String {
    let actor = Actor::load(file).unwrap();
    let mut out = String::new();
    let mut line = |text: String| out += &(text + "\n");
    line("covey_self_test(&actor) 33".into());
    line("covey_content_hash(&actor) == 0 1".into());
    line("covey_load(&actor, file, length - 1) 1".into());
    line("covey_encode(&actor, view.observation, &own) 33".into());
    line("covey_load(&actor, file, length) 0".into());
    line("covey_encode(&actor, view.observation, &own) 34".into());
    line("covey_decide(&actor, &own, 1, NULL, 0, COVEY_SAMPLE, 1, 2, 3, &decision) 34".into());
    line("covey_self_test(&actor) 0".into());
    line("covey_load(NULL, file, length) 32".into());
    line("covey_encode(&actor, NULL, &own) 32".into());
    line(format!("content hash {:016x}", actor.content_hash()));
    line(format!("message hash {:08x}", actor.message_hash()));
    line(format!("signature {:016x}", signature(&actor, 100)));
    line(format!("covey_feature_width(&actor) {}", actor.dimensions().feature));
    let tie = actor.tie_breaker(SEED, ID, STEP);
    line(format!("covey_tie_breaker(&actor, 10, 7, 5) {tie}"));

    let own = State { position: Vec2 { x: 102_400, y: 102_400 }, velocity: Vec2 { x: 2048, y: -1024 } };
    let mut neighbours = Neighbours::new();
    for i in (0..20).filter(|&i| i != 4) {
        let (offset, velocity) = (Vec2 { x: 900 * i, y: -300 * i }, Vec2 { x: 10 * i, y: -20 * i });
        neighbours.offer(Neighbour { id: 100 + i as u16, offset, velocity, tie: (3 * i - 30) as i8 });
    }
    let pois = (0..30).map(|i| Vec2 { x: 102_400 - 700 * i, y: 102_400 + 100 * i });
    let observation = observe(&Scene { id: ID, own, tie, half_side: 102_400, neighbours: &neighbours }, pois);
    let count = neighbours.as_slice().len();
    let degree = count as u8 + 1;
    let kept = neighbours.as_slice().iter().map(|n| n.id).chain(std::iter::repeat(0)).take(MAX_NEIGHBOURS);
    line("covey_observe(&scene, &view) 0".into());
    line(format!("observation{}", numbers(observation)));
    line(format!("degree {degree} kept{}", numbers(kept)));
    line("covey_encode(&actor, view.observation, &own) 0".into());
    let h = actor.encode(&observation);
    line(format!("feature{} {} {}", numbers(h.values), h.attending, h.attended));

    let width = usize::from(actor.dimensions().feature);
    let values: Vec<Vec<i8>> =
        (0..count).map(|i| (0..width).map(|k| ((7 * i + 5 * k) % 128) as i8).collect()).collect();
    let features = values.iter().zip(0..).map(|(values, i)| NeighbourFeature {
        values,
        degree: 1 + i as u8,
        attended: 40 * i - 300,
    });
    let logits = actor.logits(&h, degree, features);
    for mode in [Mode::Sample, Mode::Argmax] {
        line("covey_decide(&actor, &own, view.degree, features, (size_t)count, mode, 10, 7, 5, &decision) 0".into());
        let action = actor.choose(&logits, mode, SEED, ID, STEP).index();
        line(format!("action {action} logits{}", numbers(logits)));
    }
    let decide =
        |arguments: &str, status: i32| format!("covey_decide(&actor, &own, {arguments}, 10, 7, 5, &decision) {status}");
    line(decide("1, NULL, 0, COVEY_ARGMAX", 0));
    let alone = actor.choose(&actor.logits(&h, 1, []), Mode::Argmax, SEED, ID, STEP).index();
    line(format!("alone {alone}"));
    line(decide("0, NULL, 0, COVEY_ARGMAX", 36));
    line(decide("18, NULL, 0, COVEY_ARGMAX", 36));
    line(decide("1, NULL, 0, 2", 36));
    line(decide("1, NULL, 1, COVEY_ARGMAX", 32));
    line(decide("1, features, 17, COVEY_ARGMAX", 36));
    line(decide("1, features, 1, COVEY_ARGMAX", 36));
    line(decide("1, features, 1, COVEY_ARGMAX", 32));
    line("covey_observe(&scene, &view) 32".into());
    line("covey_observe(NULL, &view) 32".into());
    line("the actor gives other logits than when it was exported: do not fly; unknown status".into());
    out
}

#[test]
fn a_c_program_flies_as_rust_does() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let work = tempfile::tempdir().unwrap();
    let program = work.path().join("flight");
    run(compiler()
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-I"])
        .arg(here.join("include"))
        .arg(here.join("tests/flight.c"))
        .arg(library())
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(&program));
    for (aggregation, seed) in [(Aggregation::None, 1), (Aggregation::Gcn, 2), (Aggregation::Gat, 3)] {
        let file = sample_actor(aggregation, seed);
        let path = work.path().join("sample.actor");
        std::fs::write(&path, &file).unwrap();
        let printed = run(Command::new(&program).arg(&path));
        let expected = expected_layout() + &expected_flight(&file);
        for (number, (got, want)) in printed.lines().zip(expected.lines()).enumerate() {
            assert_eq!(got, want, "line {}", number + 1);
        }
        assert_eq!(printed.lines().count(), expected.lines().count());
    }
}

/// `covey_…` before each `(` in a text, where `before` stands in front.
fn functions(text: &str, before: &str) -> BTreeSet<String> {
    let starts = text.match_indices(before).map(|(at, _)| &text[at + before.len()..]);
    starts.filter_map(|rest| rest.split_once('(')).map(|(name, _)| name.to_owned()).collect()
}

#[test]
fn header_and_library_have_the_same_functions() {
    let sources = [include_str!("../src/actor.rs"), include_str!("../src/scene.rs"), include_str!("../src/status.rs")];
    let exported = functions(&sources.concat(), "extern \"C\" fn ");
    let declared: BTreeSet<String> = HEADER
        .lines()
        .filter(|l| !l.starts_with(' ') && l.contains('(') && l.contains(" covey_") || l.contains("*covey_"))
        .filter_map(|l| l.split_once('(')?.0.rsplit([' ', '*']).next().map(str::to_owned))
        .collect();
    assert_eq!(declared, exported);
    assert_eq!(exported.len(), 11);
}

#[test]
fn every_status_has_a_text_of_its_own() {
    let texts: BTreeSet<_> = Status::ALL.iter().map(|(_, text)| text).collect();
    assert_eq!(texts.len(), Status::ALL.len());
    let numbers: BTreeSet<_> = Status::ALL.iter().map(|&(status, _)| status as i32).collect();
    assert_eq!(numbers.len(), Status::ALL.len());
}
