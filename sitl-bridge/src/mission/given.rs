//! What a user gives besides a mission file.

use firmware_core::actor::Mode;

/// What a user gives besides the file. It goes over what stands there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Given {
    /// Latitude of the map's south-west corner, degrees.
    pub lat: Option<f64>,
    /// Its longitude, degrees.
    pub lon: Option<f64>,
    /// Its altitude above mean sea level, m.
    pub alt_m: Option<f64>,
    /// Metres in a map unit.
    pub scale_m: Option<f64>,
    /// Side of the map, u.
    pub side_u: Option<f64>,
    /// Length of a step, ms.
    pub step_ms: Option<u16>,
    /// Seed of actions and tie-breakers.
    pub policy_seed: Option<u64>,
    /// How actions are drawn.
    pub mode: Option<Mode>,
    /// When step 0 begins, Unix time in ms.
    pub epoch_unix_ms: Option<i64>,
    /// Altitude of the lowest layer above the origin, m.
    pub base_m: Option<f64>,
    /// Between two layers, m.
    pub spacing_m: Option<f64>,
    /// Number of layers.
    pub layers: Option<u16>,
    /// How far outside the map the fence stands where none is drawn, u.
    pub margin_u: Option<f64>,
    /// Whether a fence with too many corners is made simpler.
    pub simplify_fence: bool,
}
