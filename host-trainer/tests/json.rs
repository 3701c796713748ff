//! `--json`: what other programs read.

mod common;

use common::{succeed, train, trainer};
use serde_json::Value;
use std::path::Path;

const METRICS: [&str; 7] = ["coverage", "coverage_last", "energy", "individual", "group", "reward", "fairness"];

fn parsed(out: &str) -> Value {
    serde_json::from_str(out).unwrap_or_else(|e| panic!("{e}: {out}"))
}

fn rows(flags: &[&str], path: Option<&Path>) -> Vec<Value> {
    let done = succeed(trainer().args(["eval", "--json", "--worlds", "3"]).args(flags).args(path));
    parsed(&done.out).as_array().expect("an array").clone()
}

/// Every key that is promised, with a value of its kind.
fn check(row: &Value, scenario: &str, uavs: u64, decide: &str) {
    assert_eq!(row["scenario"], scenario, "{row}");
    assert_eq!(row["uavs"], uavs, "{row}");
    assert_eq!((row["worlds"].as_u64(), row["decide"].as_str()), (Some(3), Some(decide)), "{row}");
    assert!(row["policy"].is_string() && row["seed"].is_u64(), "{row}");
    for metric in METRICS {
        let mean = row[metric].as_f64().unwrap_or_else(|| panic!("no {metric} in {row}"));
        let error = row[format!("{metric}_se")].as_f64().unwrap_or_else(|| panic!("no error of {metric} in {row}"));
        assert!(mean.is_finite() && error.is_finite() && error >= 0.0, "{metric}: {mean} ± {error}");
    }
    for share in ["coverage", "coverage_last", "energy", "fairness"] {
        assert!((0.0..=1.0).contains(&row[share].as_f64().expect("a number")), "{share} in {row}");
    }
}

#[test]
fn eval_prints_a_row_for_each_number_of_uavs() {
    let found = rows(&["--policy", "centroid", "--uavs", "3,8", "--poi-distribution", "uniform", "--seed", "5"], None);
    assert_eq!(found.len(), 2);
    for (row, uavs) in found.iter().zip([3, 8]) {
        check(row, "uniform", uavs, "rule");
        assert_eq!((&row["policy"], &row["seed"]), (&"centroid".into(), &5.into()));
    }
    for policy in ["random", "hover", "greedy", "oracle", "parked"] {
        let found = rows(&["--policy", policy, "--uavs", "2"], None);
        assert_eq!((found.len(), &found[0]["policy"]), (1, &policy.into()));
        check(&found[0], "clustered", 2, "rule");
        assert_eq!(found[0]["seed"], 777);
    }
}

#[test]
fn eval_of_a_run_prints_int8_and_float_beside_each_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("run");
    succeed(train(&run, &["episodes=4"]).args(["--graph", "gat", "--quiet"]));
    let found = rows(&["--uavs", "4", "--decide", "argmax", "--float", "--run"], Some(&run));
    assert_eq!(found.len(), 2);
    found.iter().for_each(|row| check(row, "clustered", 4, "argmax"));
    assert_eq!([&found[0]["policy"], &found[1]["policy"]], ["gat int8", "gat float"]);
    let found = rows(&["--uavs", "4", "--model"], Some(&run.join("actor.postcard")));
    assert_eq!(found.len(), 1);
    check(&found[0], "clustered", 4, "sample");
    // The same numbers when asked again.
    assert_eq!(rows(&["--uavs", "4", "--model"], Some(&run.join("actor.postcard"))), found);
}

/// Without a model, a run or a policy it is the actor that comes with Covey.
#[test]
fn the_actor_that_comes_with_covey_flies() {
    let found = rows(&["--uavs", "3"], None);
    assert_eq!(found.len(), 1);
    check(&found[0], "clustered", 3, "sample");
    assert!(found[0]["policy"].as_str().is_some_and(|p| p.ends_with(" int8")), "{}", found[0]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("actors/gcn.postcard");
    let said = succeed(trainer().arg("inspect").arg(file)).out;
    assert!(said.contains("a sound actor") && said.contains("self-test      passed"), "{said}");
}

#[test]
fn bench_prints_four_rates() {
    let mut bench = trainer();
    bench.args(["bench", "--json", "--repeats", "1", "--threads", "2", "--graph", "none"]);
    for setting in common::TINY {
        bench.args(["--set", setting]);
    }
    let object = parsed(&succeed(&mut bench).out);
    for rate in ["env", "policy", "update", "train"] {
        let rate = object[format!("{rate}_agent_steps_per_s")].as_f64().expect("a rate");
        assert!(rate.is_finite() && rate > 0.0, "{object}");
    }
    assert_eq!((object["threads"].as_u64(), object["epochs"].as_u64()), (Some(2), Some(2)), "{object}");
}

/// What `settings` prints is a settings file with every default.
#[test]
fn the_list_of_settings_is_a_settings_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, run) = (folder.path().join("all.toml"), folder.path().join("run"));
    std::fs::write(&file, succeed(trainer().arg("settings")).out).expect("written");
    succeed(train(&run, &["episodes=4"]).args(["--quiet", "--config"]).arg(&file));
}

/// The report of a run, and one of two runs.
#[test]
fn reports_are_written_again_and_compare_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let runs = ["none", "gcn"].map(|graph| {
        let run = folder.path().join(graph);
        succeed(train(&run, &["episodes=8"]).args(["--graph", graph, "--quiet"]));
        run
    });
    let first = std::fs::read(runs[0].join("report.html")).expect("a report");
    succeed(trainer().arg("report").arg(&runs[0]));
    assert!(std::fs::read(runs[0].join("report.html")).expect("a report") == first, "another page");
    let page = folder.path().join("both.html");
    succeed(trainer().arg("report").args(&runs).arg("--out").arg(&page));
    let page = std::fs::read_to_string(page).expect("a report");
    assert!(page.contains("<svg") && page.contains("none") && page.contains("gcn"));
}
