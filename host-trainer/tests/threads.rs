//! Results do not depend on the number of threads.

mod common;

use common::{assert_same, results, succeed, train, trainer};

/// Everything a run leaves, on one, two and three threads.
fn trains_the_same(graph: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |threads: &str| {
        let out = folder.path().join(threads);
        succeed(train(&out, &["episodes=16", "shards=3"]).args(["--graph", graph, "--threads", threads, "--quiet"]));
        results(&out)
    };
    let one = run("1");
    let rows = one["metrics.jsonl"].iter().filter(|&&b| b == b'\n').count();
    assert_eq!(rows, 4, "a row a round");
    for threads in ["2", "3"] {
        assert_same(&one, &run(threads), &format!("{graph}, 1 and {threads} threads"));
    }
}

#[test]
fn training_without_a_graph_is_the_same_on_any_number_of_threads() {
    trains_the_same("none");
}

#[test]
fn training_gcn_is_the_same_on_any_number_of_threads() {
    trains_the_same("gcn");
}

#[test]
fn training_gat_is_the_same_on_any_number_of_threads() {
    trains_the_same("gat");
}

#[test]
fn another_seed_or_number_of_shards_is_another_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |setting: &str| {
        let out = folder.path().join(setting);
        succeed(train(&out, &["episodes=8", setting]).arg("--quiet"));
        results(&out)["metrics.jsonl"].clone()
    };
    let runs = ["seed=1", "seed=2", "shards=4"].map(run);
    assert!(runs[0] != runs[1] && runs[1] != runs[2] && runs[0] != runs[2]);
}

/// Networks of full width on large swarms, where matrix products are large enough for a
/// library to split them.
#[test]
fn evaluation_is_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("run");
    succeed(train(&run, &["episodes=4", "hidden=128", "feature=64", "head=64", "eval_worlds=2"]).arg("--quiet"));
    let rows = |threads: &str| {
        let mut eval = trainer();
        eval.args(["eval", "--float", "--uavs", "7,90", "--worlds", "3", "--json", "--threads", threads, "--run"]);
        let done = succeed(eval.arg(&run));
        // Of what is told beside, the agreements: progress has times in it.
        let agreement = |part: &str| part.split_inclusive("decisions").next().map(str::to_owned);
        let told: Vec<_> = done.err.split("argmax agreement").skip(1).map(agreement).collect();
        (done.out, told)
    };
    let one = rows("1");
    assert!(one.0.contains("gcn float") && one.1.len() == 2, "{one:?}");
    for threads in ["2", "3"] {
        assert!(rows(threads) == one, "1 and {threads} threads");
    }
}
