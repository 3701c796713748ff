//! The formats of mission files.

/// The formats that missions are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Covey's own.
    Toml,
    /// RFC 7946, also as a sequence of texts (RFC 8142, or one a line).
    GeoJson,
    /// Google Earth's places.
    Kml,
    /// A table of points.
    Csv,
    /// QGroundControl's plan.
    Plan,
    /// A list of waypoints as Mission Planner, MAVProxy and QGroundControl write it.
    Waypoints,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Toml => "TOML",
            Self::GeoJson => "GeoJSON",
            Self::Kml => "KML",
            Self::Csv => "CSV",
            Self::Plan => "a QGroundControl plan",
            Self::Waypoints => "a waypoint list (QGC WPL)",
        })
    }
}
