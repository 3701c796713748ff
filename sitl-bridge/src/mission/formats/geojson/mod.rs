//! Missions drawn on a map: GeoJSON whose points are PoIs and whose polygon, if it has one, is the fence. Everything
//! else stands in a member `covey`, beside `features`.
//!
//! Read are a `FeatureCollection`, a single feature or geometry, and a sequence of them: one a line, or with record
//! separators (RFC 8142).

mod crs;
mod document;
mod geometry;
mod kind;

pub(in crate::mission) use document::{Read, read};
