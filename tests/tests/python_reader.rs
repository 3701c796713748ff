//! `docs/read_actor.py`, a second implementation of the actor file and of the actor's
//! arithmetic, reads the committed actors and computes what this code computes.

use firmware_core::actor::{Actor, ActorInput, CellsActor, QuantisedActor, fingerprint};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Neighbourhoods in the compared signatures: each number of neighbours once.
const CASES: u32 = 17;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the package lies in the workspace").to_owned()
}

/// The committed sample actors.
fn actors() -> Vec<PathBuf> {
    let folder = root().join("firmware-core/tests/data");
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let files = entries.map(|e| e.expect("an entry").path()).filter(|p| p.extension().is_some_and(|e| e == "actor"));
    let mut files: Vec<_> = files.collect();
    files.sort();
    files
}

fn read(file: &Path) -> Output {
    let output = Command::new("python3")
        .arg(root().join("docs/read_actor.py"))
        .arg(file)
        .args(["--signature", &CASES.to_string()])
        .output();
    output.unwrap_or_else(|e| panic!("python3: {e}. Install Python 3 (`cargo xtask setup python-venv` does so)"))
}

/// What the reader should print of a sound file.
fn expected(file: &Path) -> String {
    let bytes = std::fs::read(file).expect("a readable file");
    match Actor::load(&bytes) {
        Ok(actor) => expected_of(file, bytes.len(), &actor),
        Err(_) => expected_of(file, bytes.len(), &CellsActor::load(&bytes).expect("a sound actor of either form")),
    }
}

fn expected_of<O: ActorInput>(file: &Path, len: usize, actor: &QuantisedActor<'_, O>) -> String {
    actor.self_test().expect("the self-test");
    let (d, p) = (actor.dimensions(), actor.provenance());
    [
        format!("file          {}: a sound actor, {} bytes", file.display(), len),
        format!("aggregation   {}", actor.aggregation().name()),
        format!("widths        {} {} {} {} {}", d.observation, d.hidden, d.feature, d.head, d.actions),
        format!("tie period    {}", actor.tie_period()),
        format!("content hash  {:016x}, in messages {:08x}", actor.content_hash(), actor.message_hash()),
        "self-test     8 of 8 vectors give the same logits".to_owned(),
        format!(
            "trained by    {} on {}, {} UAVs, seed {}, {} episodes",
            p.trainer, p.scenario, p.uavs, p.seed, p.episodes
        ),
        format!("coverage      {}/10000 int8, {}/10000 float, {} worlds", p.int8_coverage, p.float_coverage, p.worlds),
        format!("signature     {:016x} over {CASES} cases", fingerprint(actor, CASES)),
    ]
    .join("\n")
        + "\n"
}

#[test]
fn the_python_reader_agrees_on_every_committed_actor() {
    let files = actors();
    assert!(files.len() >= 6, "one actor of each aggregation and one that observes cells, not {files:?}");
    for file in files {
        let output = read(&file);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {errors}", file.display());
        assert_eq!(String::from_utf8_lossy(&output.stdout), expected(&file));
    }
}

#[test]
fn the_python_reader_refuses_damaged_files() {
    let file = actors().pop().expect("a sample");
    let sound = std::fs::read(&file).expect("a readable file");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let damaged = folder.path().join("damaged.actor");
    let flipped = |at: usize| {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        bytes
    };
    // Magic, version, length, weights, checksum; then cut and extended files.
    let mut cases: Vec<_> = [0, 8, 12, 2000, sound.len() - 1].map(flipped).into();
    cases.extend([Vec::new(), sound[..7].to_vec(), sound[..sound.len() - 1].to_vec(), [&sound[..], &[0]].concat()]);
    for bytes in cases {
        std::fs::write(&damaged, &bytes).expect("a file");
        let output = read(&damaged);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(errors.contains("not a sound actor"), "{errors}");
        assert!(output.stdout.is_empty());
    }
}

/// With a right checksum a wrong content shows in the hash and in the self-test.
#[test]
fn the_python_reader_looks_behind_the_checksum() {
    let file = actors().pop().expect("a sample");
    let sound = std::fs::read(&file).expect("a readable file");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let forged = folder.path().join("forged.actor");
    let content = sound.len() - 4;
    // The first weights, and the last byte of the content hash.
    for at in [40, content - 1] {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        let sum = crc32(&bytes[..content]);
        bytes[content..].copy_from_slice(&sum.to_le_bytes());
        assert!(Actor::load(&bytes).is_err(), "this code refuses it too");
        std::fs::write(&forged, &bytes).expect("a file");
        let output = read(&forged);
        assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// CRC-32 of Ethernet and zlib, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |s, _| (s >> 1) ^ (0xedb8_8320 & 0u32.wrapping_sub(s & 1)))
    })
}
