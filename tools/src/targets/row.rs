//! The figures of one target and build.

use serde::{Deserialize, Serialize};

use super::qemu::Results;
use crate::error::Result;
use crate::figures::grouped;

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// Processor.
    pub target: String,
    /// Cargo's profile.
    pub profile: String,
    /// One number of the signatures of the three sample actors.
    pub signature: String,
    /// Code, bytes: of the flight program on Cortex-M, of the node elsewhere.
    pub text_bytes: u64,
    /// Constants, bytes.
    pub rodata_bytes: u64,
    /// Variables, bytes.
    pub static_ram_bytes: u64,
    /// Deepest stack of the flight program in flight, bytes; where it can be told.
    pub stack_bytes: Option<u64>,
    /// Instructions of the parts of a decision; where they can be counted.
    pub instructions: Instructions,
}

/// Exact instruction counts, for actors of the default widths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Instructions {
    /// int8 layers 128 → 64 → 64 → 17 with biases and requantisation.
    pub dense_128_64_64_17: Option<u64>,
    /// Observation to feature, GCN.
    pub encode: Option<u64>,
    /// Taking in one neighbour's feature, GCN.
    pub per_neighbour_gcn: Option<u64>,
    /// Taking in one neighbour's feature, GAT.
    pub per_neighbour_gat: Option<u64>,
    /// Feature to sampled action, no neighbours, GCN.
    pub decide: Option<u64>,
    /// Encode, 16 neighbours, decide, sample: GCN.
    pub step16_gcn: Option<u64>,
    /// Encode, 16 neighbours, decide, sample: GAT.
    pub step16_gat: Option<u64>,
}

impl Instructions {
    /// From the costs of both kinds of actor.
    ///
    /// # Errors
    /// A figure is missing.
    pub fn of(gcn: &Results, gat: &Results) -> Result<Self> {
        Ok(Self {
            dense_128_64_64_17: Some(gcn.count("dense_128_64_64_17")?),
            encode: Some(gcn.count("encode")?),
            per_neighbour_gcn: Some(gcn.count("per_neighbour")?),
            per_neighbour_gat: Some(gat.count("per_neighbour")?),
            decide: Some(gcn.count("decide")?),
            step16_gcn: Some(gcn.count("step16")?),
            step16_gat: Some(gat.count("step16")?),
        })
    }

    /// Names and figures.
    pub fn named(self) -> [(&'static str, Option<u64>); 7] {
        [
            ("dense_128_64_64_17", self.dense_128_64_64_17),
            ("encode", self.encode),
            ("per_neighbour_gcn", self.per_neighbour_gcn),
            ("per_neighbour_gat", self.per_neighbour_gat),
            ("decide", self.decide),
            ("step16_gcn", self.step16_gcn),
            ("step16_gat", self.step16_gat),
        ]
    }
}

/// The rows as a Markdown table, a column a row.
pub fn table(rows: &[Row]) -> String {
    let mut lines: Vec<(&str, Vec<String>)> = vec![
        ("signature", rows.iter().map(|row| row.signature.clone()).collect()),
        ("text, bytes", rows.iter().map(|row| grouped(row.text_bytes)).collect()),
        ("rodata, bytes", rows.iter().map(|row| grouped(row.rodata_bytes)).collect()),
        ("static RAM, bytes", rows.iter().map(|row| grouped(row.static_ram_bytes)).collect()),
        ("stack, bytes", rows.iter().map(|row| optional(row.stack_bytes)).collect()),
    ];
    for (k, (name, _)) in Instructions::default().named().into_iter().enumerate() {
        lines.push((name, rows.iter().map(|row| optional(row.instructions.named()[k].1)).collect()));
    }
    let heads: Vec<String> = rows.iter().map(|row| format!("{} {}", row.target, row.profile)).collect();
    let mut table = format!("| | {} |\n|---|{}\n", heads.join(" | "), "--:|".repeat(rows.len()));
    for (name, cells) in lines {
        table += &format!("| {name} | {} |\n", cells.join(" | "));
    }
    table
}

fn optional(value: Option<u64>) -> String {
    value.map_or_else(|| "–".into(), grouped)
}
