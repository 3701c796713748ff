//! Positions that a world refuses.

/// Why positions (given by hand, or in a snapshot) do not fit their world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlacementError {
    /// The placement has another number of UAVs than the scenario.
    #[error("placement has {got} UAVs, the scenario {want}; give as many as the scenario says")]
    Uavs {
        /// Number in the placement.
        got: usize,
        /// Number in the scenario.
        want: usize,
    },
    /// The placement has another number of PoIs than the scenario.
    #[error("placement has {got} PoIs, the scenario {want}; give as many as the scenario says")]
    Pois {
        /// Number in the placement.
        got: usize,
        /// Number in the scenario.
        want: usize,
    },
    /// A position outside the map, or not a number.
    #[error("placement puts {what} {index} at ({x}, {y}), outside the map of 0 to {side_u} u")]
    Outside {
        /// What is outside: "UAV" or "PoI".
        what: &'static str,
        /// Its index.
        index: usize,
        /// Its east position, u.
        x: f32,
        /// Its north position, u.
        y: f32,
        /// Side of the map, u.
        side_u: f32,
    },
    /// A velocity that is not a number, or not finite.
    #[error("snapshot gives UAV {index} the velocity ({vx}, {vy}), which is not finite")]
    Velocity {
        /// Its index.
        index: usize,
        /// Its east velocity, u/step.
        vx: f32,
        /// Its north velocity, u/step.
        vy: f32,
    },
}
