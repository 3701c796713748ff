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
