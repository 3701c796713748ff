//! `experiment paper`.

mod common;

#[cfg(target_os = "linux")]
use common::held::held_at;
use common::{copy, everything, files, refuse, succeed, trainer};
use host_trainer::experiments::paper::{CLAIMS, Results, page};
use std::fs;
use std::path::Path;
use std::process::Command;

/// `--quick`, smaller still.
fn quick(out: &Path, flags: &[&str]) -> Command {
    let mut command = trainer();
    command.args(["experiment", "paper", "--quick", "--worlds", "2", "--out"]).arg(out);
    for set in ["pois=20", "side=80", "steps=10", "rollout_steps=5", "uavs=6", "episodes=16", "checkpoint_every=4"] {
        command.args(["--set", set]);
    }
    command.args(flags);
    command
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Report and numbers.
fn outcome(out: &Path) -> [String; 2] {
    ["report.md", "results.json"].map(|file| text(&out.join(file)))
}

/// Both groups of runs into one report with every figure and every claim; again from the
/// numbers alone; nothing is trained twice.
#[test]
fn one_report_holds_every_figure_and_every_claim() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("whole");
    succeed(&mut quick(&out, &["--quiet"]));
    let again = succeed(&mut quick(&out, &["--settings", "shipped", "--jobs", "1"]));
    assert!(again.err.contains("4 of 4 runs to train"), "{}", again.err);
    assert!(again.err.contains("4 runs") && !again.err.contains("flying paper"), "flown twice: {}", again.err);
    let [report, numbers] = outcome(&out);
    for claim in CLAIMS {
        let row = format!("| {} | {} | ", claim.figure, claim.statement);
        assert!(report.contains(&row), "no {row} in {report}");
        assert!(report.contains(&claim.measure.words()), "{claim:?}");
    }
    for number in 5..=14 {
        assert!(report.contains(&format!("\n## Figure {number}: ")), "figure {number}");
    }
    let pictures = files(&out.join("figures"));
    assert_eq!(pictures.len(), 12);
    for picture in pictures {
        let name = picture.file_name().expect("a name").to_string_lossy().into_owned();
        assert!(report.contains(&format!("(figures/{name})")), "{name} is not shown");
        assert!(text(&picture).starts_with("<svg"), "{name}");
    }
    for part in [
        "    host-trainer experiment paper --settings shipped",
        "*remembering*",
        "GCN, Covey's defaults − plain PPO",
        "trial run",
    ] {
        assert!(report.contains(part), "no {part} in {report}");
    }
    // Nothing to train, and the same files.
    let before = everything(&out);
    let third = succeed(&mut quick(&out, &[]));
    assert!(third.err.contains("0 of 6 runs to train") && !third.err.contains("flying"), "{}", third.err);
    assert!(everything(&out) == before, "files have changed");
    // From the numbers alone.
    let elsewhere = folder.path().join("numbers");
    fs::create_dir(&elsewhere).expect("a folder");
    fs::write(elsewhere.join("results.json"), &numbers).expect("written");
    succeed(trainer().args(["experiment", "paper", "--report-only", "--out"]).arg(&elsewhere));
    assert_eq!(outcome(&elsewhere), [report.clone(), numbers]);
    let read = Results::read(&out.join("results.json")).expect("results");
    assert_eq!(page(&read), report);
    // And from the run folders.
    fs::remove_file(out.join("results.json")).expect("removed");
    let said = succeed(trainer().args(["experiment", "paper", "--report-only", "--out"]).arg(&out));
    assert!(everything(&out) == before && !said.err.contains("flying"), "{}", said.err);
}

/// The paper's statements are about its own three algorithms, whatever else was trained.
#[test]
fn other_aggregations_stand_beside_the_papers() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("beside");
    succeed(&mut quick(&out, &["--quiet", "--graphs", "none,gcn,gat,gatv2,sage", "--seeds", "1,2,3"]));
    let [report, _] = outcome(&out);
    for part in [
        "--graphs none,gcn,gat,gatv2,sage",
        "| plain PPO, GCN, GAT, GATv2, GraphSAGE |",
        "\nGATv2 and GraphSAGE beside the paper's three",
        "GraphSAGE, the paper's setting − plain PPO",
    ] {
        assert!(report.contains(part), "no {part} in {report}");
    }
    assert!(text(&out.join("figures/figure-06-coverage.svg")).contains("GATv2"));
    let with_five = Results::read(&out.join("results.json")).expect("results");
    let mut with_three = with_five.clone();
    with_three.groups[0].runs.retain(|run| !["gatv2", "sage"].contains(&run.graph.as_str()));
    for claim in CLAIMS {
        let values = |results: &Results| claim.measure.values(&results.groups[0], results);
        let (five, three) = (values(&with_five), values(&with_three));
        assert_eq!(format!("{five:?}"), format!("{three:?}"), "{}", claim.statement);
    }
    assert!(!page(&with_three).contains("GraphSAGE"));
}

/// Runs that were cut off in each way there is go on, on another number of threads, to the
/// same report.
#[test]
fn what_was_interrupted_goes_on_to_the_same_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
    let flags = ["--graphs", "none,gcn", "--seeds", "3-4", "--quiet"];
    succeed(&mut quick(&whole, &flags));
    copy(&whole, &cut);
    let remove = |name: &str| {
        let path = cut.join("runs/paper").join(name);
        if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }.expect("removed");
    };
    // In training.
    remove("gcn-seed3/checkpoints/episode-0000000016.ckpt");
    remove("gcn-seed3/actor.postcard");
    remove("gcn-seed3/evaluation.json");
    // Before the first checkpoint.
    for checkpoint in common::checkpoints(&cut.join("runs/paper/none-seed3")) {
        fs::remove_file(checkpoint).expect("removed");
    }
    remove("none-seed3/evaluation.json");
    // While measuring, and not begun.
    remove("none-seed4/evaluation.json");
    remove("gcn-seed4");
    let said =
        succeed(&mut quick(&cut, &["--graphs", "none,gcn", "--seeds", "3,4", "--jobs", "1", "--threads", "1"])).err;
    assert!(said.contains("4 of 4 runs to train"), "{said}");
    assert_eq!(outcome(&cut), outcome(&whole));
}

#[test]
#[cfg(target_os = "linux")]
fn ctrl_c_saves_and_the_same_command_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
    let flags = ["--graphs", "none,gcn", "--seeds", "3", "--episodes", "40", "--set", "checkpoint_every=1000"];
    succeed(&mut quick(&whole, &flags));
    let mut held = held_at("round:2", quick(&cut, &flags).args(["--jobs", "1"]));
    held.interrupt(libc::SIGINT);
    let done = held.end();
    assert_eq!(done.code, Some(130), "{}", done.err);
    assert!(done.err.contains("the same command goes on"), "{}", done.err);
    assert!(!cut.join("report.md").exists());
    let said = succeed(&mut quick(&cut, &flags)).err;
    assert!(said.contains("2 of 2 runs to train") && !said.contains(" 4/80 "), "{said}");
    assert_eq!(outcome(&cut), outcome(&whole));
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    refuse(
        trainer().args(["experiment", "paper", "--report-only", "--out"]).arg(&out),
        &["results.json", "experiment paper"],
    );
    let cases: [(&[&str], &[&str]); 8] = [
        (&["--seeds", "5-"], &["--seeds 5-", "10-14"]),
        (&["--seeds", "5,5"], &["none-seed5", "named twice"]),
        (&["--set", "seed=3"], &["--set seed=3", "--seeds"]),
        (&["--set", "gama=1"], &["no setting `gama`", "`gamma`"]),
        (&["--seeds", "777"], &["`eval_seed` and `seed` are both 777"]),
        (&["--jobs", "0"], &["--jobs", "at least 1"]),
        (&["--worlds", "1"], &["--worlds 1", "at least 2"]),
        (&["--settings", "best"], &["paper", "shipped"]),
    ];
    for (flags, words) in cases {
        let mut command = trainer();
        refuse(command.args(["experiment", "paper", "--quick", "--out"]).arg(&out).args(flags), words);
        assert!(!out.join("runs").exists(), "{flags:?}: a run was made");
    }
    let one = ["--graphs", "none", "--seeds", "1", "--quiet"];
    succeed(&mut quick(&out, &one));
    refuse(
        &mut quick(&out, &[&one[..], &["--set", "gamma=0.5"]].concat()),
        &["none-seed1", "gamma = 0.97", "0.5 is wanted", "--out"],
    );
    let actor = out.join("runs/paper/none-seed1/actor.postcard");
    let whole = fs::read(&actor).expect("an actor");
    fs::write(&actor, b"nothing").expect("written");
    refuse(&mut quick(&out, &one), &["no sound actor", "evaluation.json"]);
    fs::remove_file(&actor).expect("removed");
    refuse(&mut quick(&out, &one), &["no sound actor", "evaluation.json"]);
    fs::write(&actor, whole).expect("written");
    succeed(&mut quick(&out, &one));
    assert!(text(&out.join("report.md")).contains("fly as int8 actors"));
    let uniform = ["--settings", "shipped", "--set", "poi_distribution=uniform"];
    refuse(&mut quick(&out, &[&one[..], &uniform].concat()), &["poi_distribution = uniform", "clustered", "--out"]);
}
