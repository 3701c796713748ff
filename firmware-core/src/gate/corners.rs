//! How many corners a geofence may have.

/// Most corners of a geofence.
pub const MAX_CORNERS: usize = 16;
