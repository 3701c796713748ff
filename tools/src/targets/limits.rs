//! Checking the figures: fixed limits, and the committed figures.

use std::path::PathBuf;

use super::row::{self, Row};
use crate::error::Result;
use crate::figures::{self, is_close};
use crate::{document, workspace};

/// Most instructions of the layers 128 → 64 → 64 → 17, which int8 kernels are compared by.
pub const DENSE_LIMIT: u64 = 15_000;
/// Most instructions of a whole step with 16 neighbours, with graph convolution.
pub const STEP_GCN_LIMIT: u64 = 60_000;
/// Most instructions of a whole step with 16 neighbours, with graph attention.
pub const STEP_GAT_LIMIT: u64 = 75_000;
/// Most instructions of a whole step with 16 neighbours, with graph attention in the form of Brody et al.
pub const STEP_GATV2_LIMIT: u64 = 76_000;
/// Most code of the flight program, its board layer included, bytes.
pub const CODE_LIMIT: u64 = 32 * 1024;
/// Most static RAM of the flight program, with a neighbour table of 16, bytes.
pub const STATIC_RAM_LIMIT: u64 = 8 * 1024;
/// Deepest stack of the flight program, bytes.
pub const STACK_LIMIT: u64 = 2 * 1024;

/// The file with the committed figures.
fn figures_file() -> PathBuf {
    workspace::root().join("docs/targets.json")
}

/// Compares the rows with the limits and with the committed figures and returns a line for each fault.
///
/// # Errors
/// The committed figures cannot be read.
pub fn check(rows: &[Row]) -> Result<Vec<String>> {
    let committed: Vec<Row> = figures::read(&figures_file())?;
    let mut complaints = Vec::new();
    if let Some(other) = rows.iter().find(|row| row.signature != rows[0].signature) {
        complaints.push(format!("{} {}: another signature than {}", other.target, other.profile, rows[0].target));
    }
    for row in rows {
        complaints.extend(beyond_limits(row));
        match committed.iter().find(|other| other.target == row.target && other.profile == row.profile) {
            Some(other) => complaints.extend(changes(row, other)),
            None => complaints.push(format!("{} {}: not in the committed figures", row.target, row.profile)),
        }
    }
    if !complaints.is_empty() {
        complaints.push("after a deliberate change: cargo xtask targets --bless".into());
    }
    Ok(complaints)
}

/// A line for each figure of a row that is beyond its limit.
pub fn beyond_limits(row: &Row) -> Vec<String> {
    let embedded = row.stack_bytes.is_some();
    let figures = [
        ("dense_128_64_64_17, instructions", row.instructions.dense_128_64_64_17, DENSE_LIMIT),
        ("step16_gcn, instructions", row.instructions.step16_gcn, STEP_GCN_LIMIT),
        ("step16_gat, instructions", row.instructions.step16_gat, STEP_GAT_LIMIT),
        ("step16_gatv2, instructions", row.instructions.step16_gatv2, STEP_GATV2_LIMIT),
        ("step16_sage, instructions", row.instructions.step16_sage, STEP_GCN_LIMIT),
        ("code, bytes", embedded.then_some(row.text_bytes), CODE_LIMIT),
        ("static RAM, bytes", embedded.then_some(row.static_ram_bytes), STATIC_RAM_LIMIT),
        ("stack, bytes", row.stack_bytes, STACK_LIMIT),
    ];
    let over = |(name, figure, limit): (&str, Option<u64>, u64)| {
        let figure = figure.filter(|&figure| figure > limit)?;
        Some(format!("{} {}: {name}: {figure}, at most {limit}", row.target, row.profile))
    };
    figures.into_iter().filter_map(over).collect()
}

/// A line for each difference between a row and the committed one.
fn changes(row: &Row, committed: &Row) -> Vec<String> {
    let mut found = Vec::new();
    let name = format!("{} {}", row.target, row.profile);
    if row.signature != committed.signature {
        found.push(format!("{name}: signature {}, committed {}", row.signature, committed.signature));
    }
    for ((figure, now), (_, then)) in row.instructions.named().into_iter().zip(committed.instructions.named()) {
        let close = match (now, then) {
            (Some(now), Some(then)) => is_close(now, then),
            (now, then) => now == then,
        };
        if !close {
            let text = |value: Option<u64>| value.map_or_else(|| "none".into(), |value| value.to_string());
            found.push(format!("{name}: {figure}: {} instructions, committed {}", text(now), text(then)));
        }
    }
    found
}

/// Writes the rows to the file of committed figures and to the table in the document.
///
/// # Errors
/// A file cannot be read or written, or the comments around the table are missing.
pub fn bless(rows: &[Row]) -> Result<()> {
    figures::write(&figures_file(), rows)?;
    document::replace_table("docs/targets.md", "targets", &row::table(rows))
}

#[cfg(test)]
mod tests {
    use super::super::row::Instructions;
    use super::*;

    fn sound() -> Row {
        Row {
            target: "cortex-m7".into(),
            profile: "release".into(),
            signature: "00".into(),
            text_bytes: CODE_LIMIT,
            rodata_bytes: 1 << 20,
            static_ram_bytes: STATIC_RAM_LIMIT,
            stack_bytes: Some(STACK_LIMIT),
            instructions: Instructions {
                dense_128_64_64_17: Some(DENSE_LIMIT),
                step16_gcn: Some(STEP_GCN_LIMIT),
                step16_gat: Some(STEP_GAT_LIMIT),
                step16_gatv2: Some(STEP_GATV2_LIMIT),
                step16_sage: Some(STEP_GCN_LIMIT),
                ..Instructions::default()
            },
        }
    }

    #[test]
    fn a_limit_itself_is_allowed_and_one_more_is_not() {
        assert!(beyond_limits(&sound()).is_empty());
        let over = [
            Row { text_bytes: CODE_LIMIT + 1, ..sound() },
            Row { static_ram_bytes: STATIC_RAM_LIMIT + 1, ..sound() },
            Row { stack_bytes: Some(STACK_LIMIT + 1), ..sound() },
            Row {
                instructions: Instructions { step16_gat: Some(STEP_GAT_LIMIT + 1), ..sound().instructions },
                ..sound()
            },
        ];
        for row in over {
            assert_eq!(beyond_limits(&row).len(), 1, "{row:?}");
        }
    }

    #[test]
    fn programs_for_computers_have_no_size_limit() {
        assert!(beyond_limits(&Row { stack_bytes: None, text_bytes: 1 << 30, ..sound() }).is_empty());
    }

    #[test]
    fn counts_may_move_three_in_a_hundred() {
        let with = |encode| Row { instructions: Instructions { encode, ..sound().instructions }, ..sound() };
        assert!(changes(&with(Some(1030)), &with(Some(1000))).is_empty());
        assert!(changes(&with(Some(970)), &with(Some(1000))).is_empty());
        assert_eq!(changes(&with(Some(1031)), &with(Some(1000))).len(), 1);
        assert_eq!(changes(&with(Some(969)), &with(Some(1000))).len(), 1);
        assert_eq!(changes(&with(None), &with(Some(1000))).len(), 1);
        assert_eq!(changes(&Row { signature: "01".into(), ..sound() }, &sound()).len(), 1);
    }
}
