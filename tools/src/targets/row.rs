//! The figures of one build, and the table of all builds.

use serde::{Deserialize, Serialize};

use super::qemu::Results;
use crate::error::Result;
use crate::figures::grouped;

/// The figures of one build. They are a column of the table, and an object in the JSON file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the processor.
    pub target: String,
    /// Name of the build profile.
    pub profile: String,
    /// The combined signature of the sample actors, one of each aggregation, 16 hexadecimal digits.
    pub signature: String,
    /// Code, bytes: of the flight program on Cortex-M, of the node elsewhere.
    pub text_bytes: u64,
    /// Constants, bytes.
    pub rodata_bytes: u64,
    /// Static RAM, bytes.
    pub static_ram_bytes: u64,
    /// Deepest stack of the flight program in test flights, bytes; `None` for computers.
    pub stack_bytes: Option<u64>,
    /// Instructions of the parts of a decision.
    pub instructions: Instructions,
}

/// Exact instruction counts for actors with the default layer widths; `None` for computers.
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
    /// Taking in one neighbour's feature, GATv2.
    pub per_neighbour_gatv2: Option<u64>,
    /// Feature to sampled action, no neighbours, GCN.
    pub decide: Option<u64>,
    /// Encode, 16 neighbours, decide, sample: GCN.
    pub step16_gcn: Option<u64>,
    /// Encode, 16 neighbours, decide, sample: GAT.
    pub step16_gat: Option<u64>,
    /// Encode, 16 neighbours, decide, sample: GATv2.
    pub step16_gatv2: Option<u64>,
    /// Encode, 16 neighbours, decide, sample: `GraphSAGE`.
    pub step16_sage: Option<u64>,
}

impl Instructions {
    /// The counts from the results of an actor of each aggregation.
    ///
    /// # Errors
    /// A count is missing.
    pub fn of([gcn, gat, gatv2, sage]: [&Results; 4]) -> Result<Self> {
        Ok(Self {
            dense_128_64_64_17: Some(gcn.count("dense_128_64_64_17")?),
            encode: Some(gcn.count("encode")?),
            per_neighbour_gcn: Some(gcn.count("per_neighbour")?),
            per_neighbour_gat: Some(gat.count("per_neighbour")?),
            per_neighbour_gatv2: Some(gatv2.count("per_neighbour")?),
            decide: Some(gcn.count("decide")?),
            step16_gcn: Some(gcn.count("step16")?),
            step16_gat: Some(gat.count("step16")?),
            step16_gatv2: Some(gatv2.count("step16")?),
            step16_sage: Some(sage.count("step16")?),
        })
    }

    /// The counts with their names.
    pub fn named(self) -> [(&'static str, Option<u64>); 10] {
        [
            ("dense_128_64_64_17", self.dense_128_64_64_17),
            ("encode", self.encode),
            ("per_neighbour_gcn", self.per_neighbour_gcn),
            ("per_neighbour_gat", self.per_neighbour_gat),
            ("per_neighbour_gatv2", self.per_neighbour_gatv2),
            ("decide", self.decide),
            ("step16_gcn", self.step16_gcn),
            ("step16_gat", self.step16_gat),
            ("step16_gatv2", self.step16_gatv2),
            ("step16_sage", self.step16_sage),
        ]
    }
}

/// Formats the rows as a Markdown table with a column for each build.
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

/// Formats a figure, or a dash where there is none.
fn optional(value: Option<u64>) -> String {
    value.map_or_else(|| "–".into(), grouped)
}
