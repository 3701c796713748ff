//! Recorded flights, decided again.

use crate::sim::{UAVS, bridge, flown, fly, tlog, words};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, Vec2};
use firmware_core::message::Message;
use serde_json::Value;
use sitl_bridge::frame::{Encoder, Frame};
use sitl_bridge::swarm_link::neighbour_message;
use sitl_bridge::tlog::{Record, TlogReader, TlogWriter};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use tempfile::TempDir;

const V2_EXTENSION: u32 = 248;
/// Offset of a feature's values in V2_EXTENSION's payload.
const VALUES: usize = 5 + 18;

fn replay(file: &Path, folder: &Path, options: &[&str]) -> Output {
    let mission = folder.join("world-0.toml");
    let mut args = vec!["replay", file.to_str().unwrap(), "--mission", mission.to_str().unwrap()];
    args.extend(options);
    bridge(&args)
}

fn report(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", words(output)))
}

fn records(file: &Path) -> Vec<Record> {
    TlogReader::open(file).unwrap().map(Result::unwrap).collect()
}

/// Another recording, of these records.
fn written(records: &[Record]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.tlog");
    let mut writer = TlogWriter::create(&path).unwrap();
    records.iter().for_each(|record| writer.record(record.unix_us, &record.frame));
    drop(writer);
    (folder, path)
}

/// Two UAVs that see each other at step 4: the nearest pair.
fn pair() -> (u16, u16) {
    let beacons: Vec<_> = records(&tlog(flown(), 0))
        .iter()
        .filter_map(|record| match neighbour_message(&record.frame)? {
            Message::Beacon(beacon) if beacon.header().step == 4 => Some((beacon.header().id, beacon.state().position)),
            _ => None,
        })
        .collect();
    let pairs = beacons.iter().flat_map(|a| beacons.iter().filter(|b| b.0 > a.0).map(move |b| (a, b)));
    let apart =
        |(a, b): &(&(u16, Vec2), &(u16, Vec2))| (a.1.to_u().0 - b.1.to_u().0).hypot(a.1.to_u().1 - b.1.to_u().1);
    let nearest = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))).expect("two beacons");
    assert!(apart(&nearest) < COMMUNICATION_RANGE_U as f32, "they see each other");
    (nearest.0.0, nearest.1.0)
}

fn is_told_by(frame: &Frame, uav: u16) -> bool {
    neighbour_message(frame).is_some_and(|message| message.header().id == uav)
}

#[test]
fn every_decision_of_every_uav_is_the_same() {
    for uav in 0..UAVS {
        let output = replay(&tlog(flown(), uav), flown(), &["--simulated", "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", words(&output));
        let told = report(&output);
        let report = &told["account"];
        assert_eq!((told["uav"].as_u64(), told["skipped_bytes"].as_u64()), (Some(uav.into()), Some(0)));
        assert_eq!(report["differences"], serde_json::json!([]), "{told}");
        // Some begin the step after the last before the flight is ended.
        for what in ["decisions", "compared", "equal", "features"] {
            assert!(matches!(report[what].as_u64(), Some(12 | 13)), "{what}: {told}");
        }
    }
}

#[test]
fn other_vehicles_dynamics_and_signed_links_replay_too() {
    let key = tempfile::NamedTempFile::new().unwrap();
    fs::write(key.path(), "ab".repeat(32)).unwrap();
    for (flight, again) in [
        (&["--px4"][..], "--simulated"),
        (&["--ideal"], "--ideal"),
        (&["--signing-key-file", key.path().to_str().unwrap()], "--simulated"),
    ] {
        let folder = fly(&[&["--count", "3", "--steps", "5"], flight].concat());
        let output = replay(&tlog(folder.path(), 1), folder.path(), &[again, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{flight:?}: {}", words(&output));
        assert!(matches!(report(&output)["account"]["equal"].as_u64(), Some(5 | 6)));
    }
}

#[test]
fn another_actor_decides_otherwise() {
    let actor = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-core/tests/data/sample-gcn.actor");
    let output = replay(&tlog(flown(), 2), flown(), &["--simulated", "--actor", actor.to_str().unwrap()]);
    let words = words(&output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("was flown, and") && words.contains("step 0, UAV 2: "), "{words}");
    let output = replay(&tlog(flown(), 2), flown(), &["--json", "--actor", actor.to_str().unwrap()]);
    let told = report(&output);
    let differences = told["account"]["differences"].as_array().unwrap();
    let actions = differences.iter().filter(|d| d["kind"] == "action");
    assert!(actions.clone().count() >= 6, "{told}");
    assert!(actions.clone().all(|d| d["recorded"] != d["replayed"] && d["uav"] == 2), "{told}");
}

#[test]
fn messages_that_say_something_else_are_noticed() {
    let (uav, neighbour) = pair();
    let mut records = records(&tlog(flown(), uav));
    // From step 4 on the neighbour's features are others.
    let is_feature = |frame: &Frame| {
        is_told_by(frame, neighbour)
            && matches!(neighbour_message(frame), Some(Message::Feature(f)) if f.header().step >= 4)
    };
    for record in records.iter_mut().filter(|record| is_feature(&record.frame)) {
        let mut payload = record.frame.payload().to_vec();
        payload[VALUES..].iter_mut().for_each(|value| *value ^= 0x7f);
        let mut encoder = Encoder::new(record.frame.system(), record.frame.component());
        record.frame = encoder.encode_payload(V2_EXTENSION, &payload).unwrap();
    }
    let (_folder, path) = written(&records);
    let output = replay(&path, flown(), &["--simulated", "--json"]);
    let told = report(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    let differences = told["account"]["differences"].as_array().unwrap();
    assert!(differences.iter().all(|d| d["step"].as_u64() >= Some(4) && d["kind"] == "action"), "{told}");
    assert!(differences.iter().all(|d| d["recorded"] != d["replayed"] && d["uav"] == uav), "{told}");
}

#[test]
fn a_neighbour_who_is_missing_in_the_log_is_missed() {
    let (uav, neighbour) = pair();
    let mut records = records(&tlog(flown(), uav));
    records.retain(|record| !is_told_by(&record.frame, neighbour));
    let (_folder, path) = written(&records);
    let output = replay(&path, flown(), &["--simulated"]);
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    assert!(words(&output).contains(&format!(", UAV {uav}: ")), "{}", words(&output));
}

#[test]
fn another_flown_action_is_named() {
    let own = records(&tlog(flown(), 2));
    let other = records(&tlog(flown(), 3));
    // What UAV 2 is said to have sent, UAV 3 did: its setpoints by its times.
    let is_setpoint = |record: &&Record| record.frame.message_id() == 84;
    let mut theirs = other.iter().filter(is_setpoint);
    let mut encoder = Encoder::new(3, 191);
    let mixed: Vec<_> = own
        .iter()
        .map(|record| {
            let frame =
                theirs.next_if_setpoint(record).map(|frame| encoder.encode_payload(84, frame.payload()).unwrap());
            Record { frame: frame.unwrap_or(record.frame), ..*record }
        })
        .collect();
    let (_folder, path) = written(&mixed);
    let output = replay(&path, flown(), &["--simulated", "--json"]);
    let told = report(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told["account"]["differences"].as_array().unwrap().iter().all(|d| d["kind"] == "action"), "{told}");
}

/// The next setpoint of the others where our record is one.
trait NextIfSetpoint {
    fn next_if_setpoint(&mut self, record: &Record) -> Option<Frame>;
}

impl<'r, I: Iterator<Item = &'r Record>> NextIfSetpoint for I {
    fn next_if_setpoint(&mut self, record: &Record) -> Option<Frame> {
        if record.frame.message_id() == 84 { self.next().map(|other| other.frame) } else { None }
    }
}

#[test]
fn damaged_and_foreign_files_are_told_as_such() {
    let bytes = fs::read(tlog(flown(), 2)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.tlog");
    let again = |bytes: &[u8], options: &[&str]| {
        fs::write(&path, bytes).unwrap();
        let output = replay(&path, flown(), options);
        (output.status.code(), words(&output))
    };
    // The end is missing: what is there is the same.
    let (code, said) = again(&bytes[..bytes.len() - 100], &["--simulated"]);
    assert!(code == Some(0) && said.contains("ends in the middle of a record"), "{code:?} {said}");
    // A hole: no position for several steps.
    let (third, half) = (bytes.len() / 3, bytes.len() * 2 / 3);
    let holed = [&bytes[..third], &vec![0x55; 1000], &bytes[half..]].concat();
    let (code, said) = again(&holed, &["--simulated"]);
    assert!(said.contains("bytes belong to no record"), "{code:?} {said}");
    let (code, said) = again(b"This is no recording, but a letter.", &[]);
    assert!(code == Some(2) && said.contains("no MAVLink frame"), "{code:?} {said}");
    let (code, said) = again(&[], &[]);
    assert!(code == Some(2) && said.contains("no MAVLink frame in its 0 bytes"), "{code:?} {said}");
    let (code, said) = again(&bytes[..2000], &[]);
    assert!(code == Some(2) && said.contains("is a setpoint of a node"), "{code:?} {said}");
    let (code, said) = again(&bytes, &["--id", "77"]);
    assert!(code == Some(2) && said.contains("another UAV's recording"), "{code:?} {said}");
    let output = replay(Path::new("/nowhere/at.tlog"), flown(), &[]);
    assert!(output.status.code() == Some(2) && words(&output).contains("/nowhere/at.tlog"), "{}", words(&output));
}

#[test]
fn the_mission_of_another_time_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let mission = fs::read_to_string(flown().join("world-0.toml")).unwrap();
    let later: Vec<_> = mission
        .lines()
        .map(|line| if line.starts_with("epoch_unix_ms") { "epoch_unix_ms = 4000000000000" } else { line })
        .collect();
    fs::write(folder.path().join("world-0.toml"), later.join("\n")).unwrap();
    let output = replay(&tlog(flown(), 2), folder.path(), &["--simulated"]);
    let words = words(&output);
    assert!(words.contains("it was decided in flight") || words.contains("is it the mission"), "{words}");
    assert_ne!(output.status.code(), Some(0));
}
