//! Whatever is wrong with settings, folders and files: an error that says what and what
//! to do, an exit status other than 0, and nothing lost.

mod common;

use common::{TINY, checkpoints, copy, everything, refuse, resume, succeed, train, trainer};
use host_trainer::run::Checkpoint;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

/// A whole run, made once; tests copy it before they spoil it.
fn run_at(out: &Path) {
    static RUN: OnceLock<TempDir> = OnceLock::new();
    let whole = RUN.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        succeed(train(&folder.path().join("run"), &["episodes=12", "checkpoint_every=4"]).arg("--quiet"));
        folder
    });
    copy(&whole.path().join("run"), out);
}

/// A folder with a run of one's own in it.
fn run() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    run_at(&out);
    (folder, out)
}

// --- Settings -------------------------------------------------------------------------

#[test]
fn bad_settings_files_are_refused_before_anything_is_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (folder.path().join("my.toml"), folder.path().join("run"));
    let cases: [(&str, &[&str]); 10] = [
        ("lerning_rate = 1e-3", &["`lerning_rate`", "nearest is `learning_rate`", "settings"]),
        ("epoch = 3", &["`epoch`", "nearest is `epochs`"]),
        ("[uavs]\nn = 3", &["`uavs`", "a whole number"]),
        ("uavs = \"many\"", &["`uavs`", "a whole number", "\"many\""]),
        ("uavs = 2.5", &["`uavs`", "a whole number", "2.5"]),
        ("bootstrap_end = 1", &["`bootstrap_end`", "true or false"]),
        ("poi_distribution = \"circle\"", &["`poi_distribution`", "\"clustered\" or \"uniform\"", "circle"]),
        ("learning_rate = -1.0", &["`learning_rate`", "-1.0", "above 0"]),
        ("hidden = 3", &["`hidden`", "even"]),
        ("uavs = = 3", &["not valid TOML", "line 1"]),
    ];
    for (text, words) in cases {
        fs::write(&file, text).expect("written");
        let done = refuse(trainer().args(["train", "--config"]).arg(&file).arg("--out").arg(&out), words);
        assert!(done.err.contains("my.toml"), "the file is not named: {}", done.err);
        assert!(!out.exists(), "{text}: a run folder was made");
    }
    let missing = folder.path().join("other.toml");
    refuse(trainer().args(["train", "--config"]).arg(&missing), &["cannot read", "other.toml"]);
}

#[test]
fn bad_flags_are_refused_before_anything_is_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let cases: [(&[&str], &[&str]); 10] = [
        (&["--set", "lamda=0.9"], &["`lamda`", "nearest is `lambda`"]),
        (&["--set", "lambda"], &["`--set lambda`", "key=value"]),
        (&["--set", "gamma=1.5"], &["`gamma`", "1.5", "0 to 1"]),
        (&["--set", "num_envs=2", "--set", "shards=3"], &["`shards`", "`num_envs`"]),
        (&["--set", "rollout_steps=30"], &["`rollout_steps` (30)", "must divide `steps` (100)", "try 25"]),
        (&["--graph", "gnn"], &["gnn", "none, gcn, gat"]),
        (&["--episodes", "0"], &["`episodes`", "must be 1 to"]),
        (&["--episodes", "many"], &["many", "--episodes"]),
        (&["--threads", "0"], &["--threads 0", "at least 1"]),
        (&["--resume", "x"], &["--resume", "cannot be used with"]),
    ];
    for (flags, words) in cases {
        refuse(trainer().arg("train").args(flags).arg("--out").arg(&out), words);
        assert!(!out.exists(), "{flags:?}: a run folder was made");
    }
    refuse(trainer().args(["bench", "--set", "epohcs=1"]), &["`epohcs`", "nearest is `epochs`"]);
}

#[test]
fn bad_evaluations_are_refused() {
    let cases: [(&[&str], &[&str]); 8] = [
        (
            &["--policy", "clever"],
            &["clever", "random, hover, greedy, centroid, follower, planner, remembering, relaying, oracle, parked"],
        ),
        (&["--policy", "hover", "--poi-distribution", "ring"], &["ring", "clustered, uniform"]),
        (&["--policy", "hover", "--decide", "best"], &["best", "sample, argmax"]),
        (&["--policy", "hover", "--uavs", "5,x"], &["--uavs", "x"]),
        (&["--policy", "hover", "--uavs", "0"], &["uavs = 0", "use 1 to"]),
        (&["--policy", "hover", "--worlds", "1"], &["--worlds 1", "at least 2"]),
        (&["--policy", "hover", "--model", "a.postcard"], &["--policy", "cannot be used with"]),
        (&["--float"], &["--run"]),
    ];
    for (flags, words) in cases {
        let done = refuse(trainer().arg("eval").args(flags), words);
        assert!(done.out.is_empty(), "{flags:?}: {}", done.out);
    }
}

// --- Folders --------------------------------------------------------------------------

#[test]
fn a_folder_that_holds_a_run_is_left_alone() {
    let (_folder, out) = run();
    let before = everything(&out);
    let hint = format!("host-trainer train --resume {}", out.display());
    refuse(&mut train(&out, &[]), &["already holds a run", &hint, "another --out"]);
    assert!(everything(&out) == before, "the run was touched");
}

#[test]
fn folders_that_hold_no_run_are_not_resumed() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "text").expect("written");
    for path in [folder.path(), &folder.path().join("missing"), &file] {
        let name = path.display().to_string();
        let words = ["is not a run folder", "config.toml", name.as_str()];
        refuse(&mut resume(path), &words);
        refuse(trainer().args(["eval", "--run"]).arg(path), &words);
        refuse(trainer().arg("report").arg(path), &words);
        refuse(trainer().args(["export", "--out", "a.postcard"]).arg(path), &words);
    }
    assert_eq!(everything(folder.path()).len(), 1, "something was made");
}

#[test]
fn a_run_that_ended_before_its_first_checkpoint_says_so() {
    let (_folder, out) = run();
    for checkpoint in checkpoints(&out) {
        fs::remove_file(checkpoint).expect("removed");
    }
    refuse(&mut resume(&out), &["holds no checkpoint", "delete"]);
}

#[test]
fn a_run_whose_settings_were_edited_names_the_key() {
    let (_folder, out) = run();
    let config = out.join("config.toml");
    let original = fs::read_to_string(&config).expect("settings");
    let edits: [(&str, &str, &[&str]); 6] = [
        ("uavs = 5\n", "uavs = 6\n", &["uavs = 6", "made with 5", "put the old value back"]),
        ("graph = \"gcn\"", "graph = \"gat\"", &["graph = \"gat\"", "made with \"gcn\"", "--out"]),
        ("clip = 0.2", "clip = 0.3", &["clip = 0.3", "made with 0.2"]),
        ("uavs = 5\n", "", &["uavs = 20", "made with 5"]),
        ("clip = 0.2", "clap = 0.2", &["`clap`", "nearest is `clip`", "config.toml"]),
        ("clip = 0.2", "clip = 2", &["`clip`", "below 1", "config.toml"]),
    ];
    for (from, to, words) in edits {
        assert!(original.contains(from));
        fs::write(&config, original.replace(from, to)).expect("written");
        let before = everything(&out);
        refuse(&mut resume(&out), words);
        refuse(trainer().arg("export").arg(&out).arg("--out").arg(out.join("other.postcard")), words);
        assert!(everything(&out) == before, "{to}: the run was touched");
    }
    fs::write(&config, original).expect("written");
    succeed(resume(&out).arg("--quiet"));
}

/// Another version's defaults must not slip into a run that began without them.
#[test]
fn a_checkpoint_that_does_not_tell_all_settings_is_refused() {
    let (_folder, out) = run();
    let newest = checkpoints(&out).pop().expect("a checkpoint");
    let mut checkpoint = Checkpoint::from_bytes(&fs::read(&newest).expect("read")).expect("sound");
    let lines = checkpoint.settings.lines().filter(|l| !l.starts_with("uavs_max =") && !l.starts_with("gamma ="));
    checkpoint.settings = lines.map(|l| format!("{l}\n")).collect();
    fs::write(&newest, checkpoint.to_bytes()).expect("written");
    let before = everything(&out);
    refuse(&mut resume(&out), &["uavs_max", "gamma", "start a new run", "--config"]);
    assert!(everything(&out) == before, "the run was touched");
}

/// Below a file and in a folder of the kernel nobody can make a folder, root neither.
#[test]
fn folders_that_cannot_be_made_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "text").expect("written");
    for out in [file.join("run"), PathBuf::from("/proc/run")] {
        refuse(&mut train(&out, &[]), &["cannot make the folder", &out.display().to_string(), "another --out"]);
    }
    let (_folder, run) = run();
    for target in [file.join("a.postcard"), PathBuf::from("/proc/a.postcard")] {
        let name = target.display().to_string();
        refuse(trainer().arg("export").arg(&run).arg("--out").arg(&target), &["cannot", &name]);
        let folder = target.parent().expect("a folder").display().to_string();
        refuse(trainer().arg("report").arg(&run).arg("--out").arg(&target), &["cannot", &folder]);
    }
    assert_eq!(fs::read_to_string(&file).expect("kept"), "text");
}

// --- Checkpoints ----------------------------------------------------------------------

#[test]
fn a_damaged_checkpoint_is_named_and_the_one_before_goes_on() {
    let (folder, out) = run();
    let [.., before, newest] = &checkpoints(&out)[..] else { panic!("two checkpoints") };
    let (good, actor) = (fs::read(newest).expect("kept"), fs::read(out.join("actor.postcard")).expect("kept"));
    let name = newest.display().to_string();
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let cases: [(Vec<u8>, &str); 9] = [
        (Vec::new(), "not a checkpoint"),
        (b"COVEY".to_vec(), "not a checkpoint"),
        (good[..12].to_vec(), "cut short"),
        (good[..good.len() / 2].to_vec(), "cut short"),
        (good[..good.len() - 1].to_vec(), "cut short"),
        ([&good[..], &[0]].concat(), "extended"),
        (flipped(0), "not a checkpoint"),
        (flipped(8), "another format version"),
        (flipped(good.len() / 2), "damaged"),
    ];
    for (bytes, what) in cases {
        fs::write(newest, bytes).expect("written");
        let kept = everything(&out);
        let words = [name.as_str(), what, "delete it to go on from the checkpoint before"];
        refuse(&mut resume(&out), &words);
        refuse(trainer().arg("export").arg(&out).arg("--out").arg(folder.path().join("a.postcard")), &words);
        assert!(everything(&out) == kept, "{what}: the run was touched");
    }
    fs::remove_file(newest).expect("removed");
    assert!(before.exists());
    succeed(resume(&out).arg("--quiet"));
    assert!(fs::read(newest).expect("made again") == good);
    assert!(fs::read(out.join("actor.postcard")).expect("made again") == actor);
}

// --- Actor files ----------------------------------------------------------------------

#[test]
fn a_damaged_actor_does_not_fly() {
    let (folder, out) = run();
    let good = fs::read(out.join("actor.postcard")).expect("an actor");
    let spoilt = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    let middle = good.len() / 2;
    let cases: [(Vec<u8>, &[&str]); 8] = [
        (Vec::new(), &["cut short", "0 bytes"]),
        (good[..middle].to_vec(), &["cut short", "copy or export it again"]),
        ([&good[..], b"more"].concat(), &["4 bytes too many", "copy or export it again"]),
        (spoilt(middle, !good[middle]), &["damaged", "copy or export it again"]),
        (spoilt(good.len() - 1, !good[good.len() - 1]), &["damaged"]),
        (spoilt(8, 2), &["format 2", "format 1", "export it again"]),
        (spoilt(0, b'X'), &["not an actor file", "host-trainer export"]),
        (b"# my settings".to_vec(), &["not an actor file"]),
    ];
    let file = folder.path().join("spoilt.postcard");
    for (bytes, words) in cases {
        fs::write(&file, bytes).expect("written");
        for command in [&["eval", "--worlds", "2", "--model"][..], &["inspect"]] {
            let done = refuse(trainer().args(command).arg(&file), words);
            assert!(done.err.contains("spoilt.postcard"), "{command:?}: the file is not named: {}", done.err);
            assert!(done.out.is_empty(), "{command:?}: {}", done.out);
        }
    }
    for path in [&folder.path().join("missing.postcard"), folder.path()] {
        let name = path.display().to_string();
        refuse(trainer().args(["eval", "--model"]).arg(path), &["cannot read", &name]);
        refuse(trainer().arg("inspect").arg(path), &["cannot read", &name]);
    }
    // The actor of a run, damaged or missing.
    fs::write(out.join("actor.postcard"), &good[..middle]).expect("written");
    refuse(trainer().args(["eval", "--worlds", "2", "--run"]).arg(&out), &["cut short", "actor.postcard"]);
    fs::remove_file(out.join("actor.postcard")).expect("removed");
    refuse(trainer().args(["eval", "--worlds", "2", "--run"]).arg(&out), &["no actor file yet", "host-trainer export"]);
    succeed(trainer().arg("export").arg(&out).arg("--out").arg(out.join("actor.postcard")));
    assert!(fs::read(out.join("actor.postcard")).expect("exported") == good);
}

/// What the tiny settings say is what a run writes down.
#[test]
fn a_runs_settings_are_those_that_were_asked_for() {
    let (_folder, out) = run();
    let config = fs::read_to_string(out.join("config.toml")).expect("settings");
    for setting in TINY {
        let (key, value) = setting.split_once('=').expect("key=value");
        let line = |l: &str| l == format!("{key} = {value}") || l == format!("{key} = {value}.0");
        assert!(config.lines().any(line), "{setting} is not in config.toml");
    }
}
