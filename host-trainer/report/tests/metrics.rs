//! The metrics file: exact, and forgiving only at its end.

use std::fs;

use covey_report::metrics::{MetricsError, MetricsLog, nan_as_null, read};
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    episode: u64,
    #[serde(with = "nan_as_null")]
    coverage: f64,
}

fn row(episode: u64) -> Row {
    Row { episode, coverage: 1.0 / (episode as f64 + 3.0) }
}

#[test]
fn rows_come_back_as_they_went() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("metrics.jsonl");
    let mut log = MetricsLog::create(&path).unwrap();
    for e in 0..50 {
        log.append(&row(e)).unwrap();
        // Every row is in the file at once, without a flush or a drop.
        assert_eq!(read::<Row>(&path).unwrap().len() as u64, e + 1);
    }
    log.sync().unwrap();
    assert_eq!(read::<Row>(&path).unwrap(), (0..50).map(row).collect::<Vec<_>>());
    assert_eq!(log.rows(), 50);
}

#[test]
fn numbers_that_are_not_finite_survive_as_null() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("metrics.jsonl");
    let mut log = MetricsLog::create(&path).unwrap();
    log.append(&Row { episode: 1, coverage: f64::NAN }).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "{\"episode\":1,\"coverage\":null}\n");
    assert!(read::<Row>(&path).unwrap()[0].coverage.is_nan());
}

#[test]
fn a_file_that_exists_is_never_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("metrics.jsonl");
    MetricsLog::create(&path).unwrap().append(&row(0)).unwrap();
    let error = MetricsLog::create(&path).unwrap_err();
    assert!(error.to_string().contains("Resume that run"), "{error}");
    assert_eq!(read::<Row>(&path).unwrap(), [row(0)]);
}

#[test]
fn a_spoilt_row_in_the_middle_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("metrics.jsonl");
    fs::write(&path, "{\"episode\":1,\"coverage\":0.5}\n{\"episode\":2,\n{\"episode\":3,\"coverage\":0.5}\n").unwrap();
    let error = read::<Row>(&path).unwrap_err();
    assert!(matches!(error, MetricsError::Row { row: 2, .. }), "{error}");
}

#[test]
fn fewer_rows_than_the_checkpoint_knows_is_an_error_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("metrics.jsonl");
    let content = "{\"episode\":1,\"coverage\":0.5}\n{\"episode\":2,\"cov";
    fs::write(&path, content).unwrap();
    let error = MetricsLog::resume(&path, 2).unwrap_err();
    assert!(matches!(error, MetricsError::TooShort { found: 1, wanted: 2, .. }), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), content);
}

#[test]
fn a_missing_file_says_what_to_check() {
    let folder = tempfile::tempdir().unwrap();
    for error in [
        read::<Row>(folder.path().join("metrics.jsonl")).map(drop).unwrap_err(),
        MetricsLog::resume(folder.path().join("metrics.jsonl"), 0).map(drop).unwrap_err(),
    ] {
        assert!(error.to_string().contains("Check that this is a run folder"), "{error}");
    }
    let error = MetricsLog::create(folder.path().join("none/metrics.jsonl")).unwrap_err();
    assert!(error.to_string().contains("mkdir -p"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Killed at any byte after a checkpoint, a resumed run's file ends up the same
    /// to the byte as that of a run that was never interrupted.
    #[test]
    fn resuming_is_exact_to_the_byte(rows in 1u64..12, checkpoint in 0u64..12, killed in 0.0f64..1.0) {
        let checkpoint = checkpoint.min(rows);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.jsonl");
        let mut log = MetricsLog::create(&path).unwrap();
        let mut at_checkpoint = 0;
        for e in 0..rows {
            if e == checkpoint {
                at_checkpoint = fs::metadata(&path).unwrap().len();
            }
            log.append(&row(e)).unwrap();
        }
        drop(log);
        let whole = fs::read(&path).unwrap();
        if checkpoint == rows {
            at_checkpoint = whole.len() as u64;
        }
        let length = at_checkpoint + (killed * (whole.len() as u64 - at_checkpoint) as f64) as u64;
        fs::write(&path, &whole[..length as usize]).unwrap();
        prop_assert!(read::<Row>(&path).unwrap().len() as u64 >= checkpoint);

        let mut log = MetricsLog::resume(&path, checkpoint).unwrap();
        prop_assert_eq!(log.rows(), checkpoint);
        for e in checkpoint..rows {
            log.append(&row(e)).unwrap();
        }
        prop_assert_eq!(fs::read(&path).unwrap(), whole);
    }
}
