//! The content of a report, as plain data.

use super::chart::Chart;
use super::episode::Episode;
use super::table::{Estimate, Table};
use serde::{Deserialize, Serialize};

/// A report: what the page shows, from top to bottom.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Names the run or the comparison.
    pub title: String,
    /// One line under the title: scenario, date, length of training.
    pub subtitle: String,
    /// The sections, in order.
    pub sections: Vec<Section>,
}

/// One section of the page, under a heading of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// The heading.
    pub title: String,
    /// A sentence or two under the heading; empty for none.
    pub lead: String,
    /// What follows.
    pub content: Content,
}

/// What a section holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Content {
    /// Nothing but the lead.
    Text,
    /// Large numbers side by side.
    Figures(Vec<Figure>),
    /// A table, of which wide ones become cards on a phone.
    Table(Table),
    /// Names and values, in groups.
    Configuration(Vec<Group>),
    /// Curves; series of the same name have the same colour all over the page.
    Charts(Vec<Chart>),
    /// Episodes that share one player.
    Episodes(Vec<Episode>),
}

/// One headline number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What it is: `Coverage index`.
    pub label: String,
    /// How much.
    pub value: Estimate,
    /// Unit after the number; empty for none.
    pub unit: String,
    /// A remark under the number; empty for none.
    pub note: String,
}

/// Settings that belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// `Scenario`, `Training`.
    pub name: String,
    /// Names and values in order.
    pub entries: Vec<(String, String)>,
}
