//! The HTML report: one self-contained page from plain data.
//!
//! A [`Report`] is a title and sections: headline figures, tables, configuration,
//! curves, and episodes that play in the page. [`Report::html`] makes the page; it
//! holds everything it needs, forbids itself the network and opens from a file.
//! Every text is escaped. The same report gives the same bytes.

mod axis;
mod chart;
mod chart_html;
mod chart_svg;
mod comparison;
mod curve;
mod episode;
mod episode_svg;
mod escape;
mod page;
mod player;
mod table;

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use chart::{Chart, Reference, Series};
pub use chart_svg::chart_svg;
pub use comparison::{Run, comparison};
pub use episode::{Episode, Frame};
pub use episode_svg::episode_svg;
pub use table::{Better, Cell, Column, Estimate, Row, Table};

use crate::atomic::{self, WriteError};

/// A report: what the page shows, from top to bottom.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Names the run or the comparison.
    pub title: String,
    /// One line under the title: scenario, date, length of training.
    pub subtitle: String,
    /// The sections in order.
    pub sections: Vec<Section>,
}

/// One part of the page, under a heading of its own.
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

/// The data of a report contradict each other, or the page could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// An episode has no frame.
    #[error("episode {episode:?} has no frames: give at least the spawn state")]
    NoFrames {
        /// Its title.
        episode: String,
    },
    /// A list of an episode has the wrong length.
    #[error("episode {episode:?}, step {step}: {found} {what} where there should be {expected}")]
    Length {
        /// Its title.
        episode: String,
        /// The frame, from 0.
        step: usize,
        /// `UAVs`, `PoI states` or `actions`.
        what: &'static str,
        /// Entries found.
        found: usize,
        /// Entries wanted.
        expected: usize,
    },
    /// A link names a UAV that is not there.
    #[error("episode {episode:?}, step {step}: link {link:?} names a UAV beyond the {uavs} there are")]
    Link {
        /// Its title.
        episode: String,
        /// The frame, from 0.
        step: usize,
        /// The link.
        link: [u16; 2],
        /// UAVs in the episode.
        uavs: usize,
    },
    /// A length or a place of an episode is not a usable number.
    #[error("episode {episode:?}: {what} must be a finite number{}", if *.positive { " above 0" } else { "" })]
    Number {
        /// Its title.
        episode: String,
        /// Which one.
        what: &'static str,
        /// Whether it must be above 0 too.
        positive: bool,
    },
    /// A band does not go with its curve.
    #[error("series {series:?} of chart {chart:?} has {points} points but a band of {band}")]
    Band {
        /// The chart's title.
        chart: String,
        /// The series' name.
        series: String,
        /// Points of the curve.
        points: usize,
        /// Entries of the band.
        band: usize,
    },
    /// A step was asked for that the episode has not.
    #[error("episode {episode:?} has steps 0 to {last}, not {step}")]
    Step {
        /// Its title.
        episode: String,
        /// The step asked for.
        step: usize,
        /// The last step there is.
        last: usize,
    },
    /// The episode could not be encoded for the page.
    #[error("episode data cannot be written as JSON")]
    Encode(#[from] serde_json::Error),
    /// The page could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The folder of the page could not be made.
    #[error("cannot make the folder {folder}. Choose another place for the report")]
    Folder {
        /// The folder.
        folder: String,
        /// What the operating system said.
        source: io::Error,
    },
}

impl Report {
    /// The page.
    ///
    /// # Errors
    /// [`ReportError`] when lists that belong together differ in length.
    pub fn html(&self) -> Result<String, ReportError> {
        page::html(self)
    }

    /// Writes the page to `path` in one step ([`atomic::write`]), making its folder
    /// if missing.
    ///
    /// # Errors
    /// As [`Report::html`], and [`ReportError::Write`] or [`ReportError::Folder`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), ReportError> {
        let html = self.html()?;
        if let Some(folder) = path.as_ref().parent().filter(|f| !f.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)
                .map_err(|source| ReportError::Folder { folder: folder.display().to_string(), source })?;
        }
        Ok(atomic::write(path, html.as_bytes())?)
    }
}
