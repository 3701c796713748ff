//! The node's commands around an actor file, as a user runs them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn sample(kind: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../firmware-core/tests/data/sample-{kind}.actor"))
}

fn node(args: &[&str], file: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sitl-bridge")).args(args).arg(file).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn sound_actors_pass_and_have_different_signatures() {
    let mut signatures: Vec<String> = ["none", "gcn", "gat"]
        .map(|kind| {
            let tested = node(&["self-test"], &sample(kind));
            assert!(tested.status.success() && text(&tested.stdout).starts_with("8 vectors hold, actor "));
            let signed = node(&["signature", "--cases", "20"], &sample(kind));
            assert!(signed.status.success());
            text(&signed.stdout)
        })
        .to_vec();
    assert!(signatures.iter().all(|s| s.trim().len() == 16 && u64::from_str_radix(s.trim(), 16).is_ok()));
    signatures.sort();
    signatures.dedup();
    assert_eq!(signatures.len(), 3);
}

#[test]
fn a_damaged_file_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("damaged.actor");
    let mut bytes = std::fs::read(sample("gcn")).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&file, bytes).unwrap();
    for command in ["self-test", "signature"] {
        let refused = node(&[command], &file);
        assert!(!refused.status.success() && refused.stdout.is_empty());
        assert!(text(&refused.stderr).contains("damaged"), "{}", text(&refused.stderr));
    }
}

#[test]
fn a_missing_file_is_named() {
    let refused = node(&["self-test"], Path::new("no-such.actor"));
    assert!(!refused.status.success() && text(&refused.stderr).contains("no-such.actor"));
}

#[test]
fn a_damaged_actor_never_flies() {
    let folder = tempfile::tempdir().unwrap();
    let (mission, damaged) = (folder.path().join("m.toml"), folder.path().join("damaged.actor"));
    let sound = std::fs::read(sample("gcn")).unwrap();
    let bridge =
        |args: &[&std::ffi::OsStr]| Command::new(env!("CARGO_BIN_EXE_sitl-bridge")).args(args).output().unwrap();
    std::fs::write(&mission, bridge(&["mission".as_ref()]).stdout).unwrap();
    // A bit anywhere, and an end anywhere.
    let flipped = (0..12).map(|i| {
        let mut bytes = sound.clone();
        let at = i * (bytes.len() - 1) / 11;
        bytes[at] ^= 1 << (i % 8);
        bytes
    });
    let cut = [0, 1, sound.len() / 2, sound.len() - 1].map(|len| sound[..len].to_vec());
    for bytes in flipped.chain(cut) {
        std::fs::write(&damaged, bytes).unwrap();
        let (mission, damaged) = (mission.as_os_str(), damaged.as_os_str());
        let fly = ["fly", "--id", "0", "--takeoff", "--autopilot", "udpin:127.0.0.1:0"].map(std::ffi::OsStr::new);
        let refused = bridge(&[&fly[..], &["--mission".as_ref(), mission, "--actor".as_ref(), damaged]].concat());
        let said = text(&refused.stderr);
        assert!(!refused.status.success() && said.contains("no actor file that can fly"), "{said}");
        // It ends before any link is opened, so the autopilot never hears of it.
        assert!(!said.contains("autopilot:") && refused.stdout.is_empty(), "{said}");
    }
}
