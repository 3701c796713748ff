//! What is refused about a report.

use crate::atomic::WriteError;
use std::io;

/// Why there is no page: parts of the report contradict each other, or a file could not be written.
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
    /// An edge of the communication graph names a UAV that is not there.
    #[error("episode {episode:?}, step {step}: edge {edge:?} names a UAV beyond the {uavs} there are")]
    Edge {
        /// Its title.
        episode: String,
        /// The frame, from 0.
        step: usize,
        /// The edge.
        edge: [u16; 2],
        /// UAVs in the episode.
        uavs: usize,
    },
    /// A length or a position of an episode is not a usable number.
    #[error("episode {episode:?}: {what} must be a finite number{}", if *.positive { " above 0" } else { "" })]
    Number {
        /// Its title.
        episode: String,
        /// Which one.
        what: &'static str,
        /// Whether it must be above 0 too.
        positive: bool,
    },
    /// A curve and its band differ in length.
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
    /// The folder of the page could not be created.
    #[error("cannot create the folder {folder}. Choose another folder for the report")]
    Folder {
        /// The folder.
        folder: String,
        /// What the operating system reported.
        source: io::Error,
    },
}
