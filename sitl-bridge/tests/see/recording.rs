//! Recordings of a flight.

use crate::sim::{flown, python, tlog};
use sitl_bridge::tlog::TlogReader;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// What pymavlink's mavutil, on which MAVProxy and MAVExplorer stand, reads in a log: types and times (µs).
fn read(file: &Path) -> Vec<(String, u64)> {
    let peer = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pymavlink_peer.py");
    let output = Command::new(python()).arg(peer).arg("read-tlog").arg("--file").arg(file).output().expect("Python");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let line = |line: &str| {
        let value: serde_json::Value = serde_json::from_str(line).expect("JSON");
        (value["type"].as_str().expect("a type").to_owned(), value["us"].as_u64().expect("a time"))
    };
    String::from_utf8(output.stdout).expect("text").lines().map(line).collect()
}

#[test]
fn mavutil_reads_all_that_both_links_sent_and_took() {
    let file = tlog(flown(), 2);
    let read = read(&file);
    let ours: Vec<_> = TlogReader::open(&file).unwrap().map(Result::unwrap).collect();
    assert_eq!(read.len(), ours.len());
    for ((kind, us), record) in read.iter().zip(&ours) {
        assert_ne!(kind, "BAD_DATA");
        // Its times are floating-point seconds.
        assert!(us.abs_diff(record.unix_us) <= 1, "{us} {}", record.unix_us);
    }
    assert!(ours.windows(2).all(|pair| pair[0].unix_us <= pair[1].unix_us), "in order");
    let mut count = BTreeMap::new();
    for (kind, _) in &read {
        *count.entry(kind.as_str()).or_insert(0) += 1;
    }
    for heard in ["HEARTBEAT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "SYSTEM_TIME", "COMMAND_ACK"] {
        assert!(count.contains_key(heard), "{heard}: {count:?}");
    }
    // Twelve steps and the beginning of one more, ten positions a step, each answered.
    assert!(count["SET_POSITION_TARGET_LOCAL_NED"] >= 120 && count["COMMAND_LONG"] >= 10, "{count:?}");
    // A beacon and a feature a step, of itself and of the nine others.
    assert!(count["V2_EXTENSION"] >= 12 * 2 * 10, "{count:?}");
}
