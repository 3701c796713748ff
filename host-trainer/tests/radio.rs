//! Flights over a radio that loses messages: `eval --radio` and `experiment radio`.

mod common;

use common::{assert_same, refuse, results, resume, succeed, train, trainer};
use covey_env::radio::RadioSettings;
use serde_json::Value;
use std::fs;

fn rows(flags: &[&str]) -> Vec<Value> {
    let done = succeed(trainer().args(["eval", "--json", "--worlds", "3", "--uavs", "8"]).args(flags));
    serde_json::from_str(&done.out).unwrap_or_else(|e| panic!("{e}: {}", done.out))
}

#[test]
fn each_link_has_a_row_that_says_what_it_did() {
    let links = ["perfect", "loss=0.3,burst=4,delay_ms=300,jitter_ms=2500,corrupt=0.1,range_u=60", "loss=1"];
    let flags: Vec<&str> = links.iter().flat_map(|link| ["--radio", link]).collect();
    let found = rows(&flags);
    assert_eq!(found.iter().map(|r| r["link"].as_str()).collect::<Vec<_>>(), links.map(Some));
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap_or_else(|| panic!("no {key} in {row}"));
    for row in &found {
        // Two messages a step, from each to each other.
        assert_eq!(number(row, "datagrams_sent"), 3.0 * 100.0 * 2.0 * 8.0 * 7.0, "{row}");
        assert!((0.0..=1.0).contains(&number(row, "coverage")) && number(row, "coverage_se") >= 0.0, "{row}");
    }
    let figures = |row: &Value| {
        ["neighbours_known", "neighbours_ghost", "neighbours_with_feature", "datagrams_lost", "messages_malformed"]
            .map(|key| number(row, key))
    };
    assert_eq!(figures(&found[0]), [1.0, 0.0, 1.0, 0.0, 0.0]);
    let [known, ghosts, features, lost, malformed] = figures(&found[1]);
    assert!(known < 1.0 && ghosts > 0.0 && features < 1.0 && lost > 0.0 && malformed > 0.0, "{}", found[1]);
    assert_eq!(figures(&found[2])[..3], [0.0; 3]);
    // The same when asked again, on one thread; and the first is that of no link at all.
    assert_eq!(rows(&[&flags[..], &["--threads", "1"]].concat()), found);
    let mut bare = rows(&[]).remove(0);
    for (key, value) in found[0].as_object().expect("a row") {
        bare.as_object_mut().expect("a row").entry(key).or_insert_with(|| value.clone());
    }
    assert_eq!(bare, found[0]);
}

#[test]
fn the_table_names_the_links() {
    let out = succeed(trainer().args(["eval", "--worlds", "2", "--radio", "loss=0.5", "--radio", "perfect"])).out;
    let rows: Vec<&str> = out.lines().filter(|l| l.contains("clustered")).collect();
    assert!(rows.len() == 2 && rows[0].ends_with("  loss=0.5") && rows[1].ends_with("  perfect"), "{out}");
    assert!(out.contains("known   ghosts  features"), "{out}");
}

#[test]
fn links_that_cannot_be_are_refused() {
    let cases: [(&[&str], &[&str]); 6] = [
        (&["--radio", "los=0.1"], &["no setting `los`", "loss, burst, delay_ms"]),
        (&["--radio", "loss=2"], &["loss = 2", "0 to 1"]),
        (&["--radio", "loss=0.5,burst=1.2"], &["burst = 1.2", "2.00 in a row"]),
        (&["--radio", "loss=0.1", "--policy", "hover"], &["--radio", "cannot be used with", "--policy"]),
        (&["--radio", "loss=0.1", "--actor", "qemu-m7"], &["--radio", "cannot be used with", "--actor"]),
        (&["--radio", "loss=0.1", "--uavs", "3000"], &["3000 nodes", "1 to 2048"]),
    ];
    for (flags, words) in cases {
        let done = refuse(trainer().arg("eval").args(flags), words);
        assert!(done.out.is_empty(), "{flags:?}: {}", done.out);
    }
    refuse(trainer().args(["experiment", "radio", "--worlds", "1"]), &["--worlds 1", "at least 2"]);
}

/// In a file the settings are a table; what it leaves out is as in the perfect link.
#[test]
fn a_link_is_a_table_in_toml() {
    let read = |text: &str| toml::from_str::<RadioSettings>(text).map_err(|e| e.to_string());
    let link = read("loss = 0.1\nburst = 3\ndelay_ms = 2000\n").expect("a link");
    assert_eq!(link.to_string(), "loss=0.1,burst=3,delay_ms=2000");
    assert_eq!(read("").expect("a link"), RadioSettings::default());
    assert!(read("los = 0.1").expect_err("no such setting").contains("unknown field `los`"));
}

/// Page and picture, the same from any number of threads.
#[test]
fn the_experiment_writes_a_page_and_a_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let written = |name: &str, threads: &str| {
        let out = folder.path().join(name);
        let mut command = trainer();
        command.args(["experiment", "radio", "--worlds", "2", "--uavs", "6", "--threads", threads, "--out"]).arg(&out);
        succeed(&mut command);
        ["radio-loss.md", "radio-loss.svg"].map(|file| fs::read_to_string(out.join(file)).expect("written"))
    };
    let one = written("one", "1");
    assert_eq!(one, written("three", "3"));
    let [page, picture] = one;
    assert!(page.contains("`host-trainer experiment radio --uavs 6 --worlds 2`"), "{page}");
    for part in
        ["![", "(radio-loss.svg)", "the target is 95 %", "| 50 % |", "| `loss=0.3,burst=10` |", "| `corrupt=0.1` |"]
    {
        assert!(page.contains(part), "no {part} in {page}");
    }
    assert!(picture.starts_with("<svg") && picture.contains("2 steps late") && picture.contains("bursts of 10"));
}

/// Training over a link: the same on any number of threads and after a stop, and another
/// outcome than without.
#[test]
fn training_over_a_link_is_exact_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str, settings: &[&str], threads: &str| {
        let out = folder.path().join(name);
        succeed(train(&out, settings).args(["--quiet", "--threads", threads]));
        out
    };
    let lossy = ["episodes=12", "checkpoint_every=4", "radio_loss=0.6", "radio_delay=2"];
    let one = run("one", &lossy, "1");
    let whole = results(&one);
    assert_same(&whole, &results(&run("three", &lossy, "3")), "three threads");
    let newest = common::checkpoints(&one).pop().expect("a checkpoint");
    fs::remove_file(newest).expect("removed");
    succeed(resume(&one).arg("--quiet"));
    assert_same(&whole, &results(&one), "resumed");
    let without = results(&run("without", &lossy[..2], "2"));
    assert_ne!(whole["metrics.jsonl"], without["metrics.jsonl"]);
}

#[test]
fn links_that_cannot_be_trained_over_are_refused() {
    let out = tempfile::tempdir().expect("a folder").path().join("run");
    let cases: [(&[&str], &[&str]); 3] = [
        (&["radio_loss=1.5"], &["`radio_loss` is 1.5", "0 to 1"]),
        (&["radio_delay=3"], &["`radio_delay` is 3", "0 to 2"]),
        (&["radio_delay=1", "uavs=3000"], &["up to 3000 UAVs", "at most 2048"]),
    ];
    for (settings, words) in cases {
        refuse(&mut train(&out, settings), words);
        assert!(!out.exists(), "{settings:?}: a run folder was made");
    }
}
