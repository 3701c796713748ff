//! What a swarm flies: where its map lies, what it should cover and where it must stay.
//!
//! A mission is a file that every UAV of the swarm carries, TOML or GeoJSON, described in
//! `docs/mission.md`. Places drawn elsewhere, in KML, CSV, a QGroundControl plan or a waypoint list, become one.
//!
//! ```text
//! bytes ─ text ─ detect ─▶ geojson, kml, csv, plan, waypoints ─▶ drawing ┐
//!                     └──▶ TOML, or GeoJSON's member covey ─▶ file ──────┴▶ draft ─ check ─▶ Mission and remarks
//! ```

mod check;
mod definition;
mod draft;
mod drawing;
mod error;
mod fault;
mod file;
mod format;
mod formats;
mod given;
mod height_fields;
mod height_warnings;
mod loaded;
mod outline;
mod plane;
mod poi_check;
mod pois;
mod text;
mod world;
mod writer;

pub use definition::{DEFAULT_MARGIN_U, HeightLimits, Layers, Mission, SharedLayer, square_fence};
pub use draft::Draft;
pub use error::MissionError;
pub use file::Origin;
pub use format::Format;
pub use given::Given;
pub use loaded::{Loaded, Remark};
pub use plane::{OriginError, Place, Plane, REACH_MM, Scale, to_e7};
pub use pois::PoiMap;
pub use text::TextError;
