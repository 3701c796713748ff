//! What a geofence may be, and what can be wrong with one.

/// Most corners of a geofence.
pub const MAX_CORNERS: usize = 16;

/// A fence that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeofenceError {
    /// Not 3 to [`MAX_CORNERS`] corners.
    #[error("a fence has 3 to {MAX_CORNERS} corners, not {0}")]
    Corners(usize),
    /// A corner, or a part of the circle, is too far away.
    #[error("the fence reaches beyond 100 km from the origin")]
    TooFar,
    /// A corner lies on the next one.
    #[error("corners {0} and the next one are the same point")]
    SamePoint(usize),
    /// Edges touch or cross.
    #[error("the edges after corners {0} and {1} touch or cross")]
    Crossing(usize, usize),
    /// A corner is sharper than 30°.
    #[error("corner {0} is sharper than 30°")]
    TooSharp(usize),
    /// The circle is smaller than 1 m.
    #[error("the circle's radius is below 1 m")]
    TooSmall,
}
