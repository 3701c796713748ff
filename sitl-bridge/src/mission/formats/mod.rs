//! Readers of the formats that other tools write, and how a file's format is told.
//!
//! Each reader makes a [drawing](super::drawing) of a text: points and an outline in degrees.

pub(super) mod csv;
pub(super) mod detect;
pub(super) mod geojson;
mod json;
pub(super) mod kml;
pub(super) mod plan;
mod ring;
pub(super) mod waypoints;
