//! The report: one self-contained HTML page from plain data, and single pictures for documents.
//!
//! A [`Report`] is a title and sections: headline figures, tables, configuration, curves, and episodes that play in the
//! page. [`Report::html`] renders the page; it holds everything it needs, forbids itself the network and opens from a
//! file. Every text is escaped. The same report gives the same bytes. [`comparison`] makes a report of several runs;
//! [`chart_svg`] and [`episode_svg`] render a single chart or step.

mod axis;
mod chart;
mod chart_html;
mod chart_svg;
mod comparison;
mod curve;
mod episode;
mod episode_json;
mod episode_svg;
mod error;
mod escape;
mod model;
mod number;
mod page;
mod palette;
mod picture;
mod player;
mod table;

pub use chart::{Chart, Reference, Series};
pub use chart_svg::chart_svg;
pub use comparison::{Run, comparison};
pub use episode::{Episode, Frame};
pub use episode_svg::episode_svg;
pub use error::ReportError;
pub use model::{Content, Figure, Group, Report, Section};
pub use table::{Better, Cell, Column, Estimate, Row, Table};
