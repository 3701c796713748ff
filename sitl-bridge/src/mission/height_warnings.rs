//! What may go wrong with the heights of a mission.

use super::definition::Mission;

/// Nearer together than this, layers are mixed up by what the heights of GPS receivers differ by, m.
const NEAR_M: f64 = 5.0;

/// What may go wrong with the heights of a mission, in words.
pub(super) fn height_warnings(mission: &Mission) -> Vec<String> {
    let (layers, limit_m) = (mission.layers, mission.heights.highest_above_home_m);
    let mut warnings = Vec::new();
    let altitude_m = |id| f64::from(layers.altitude_mm(id)) / 1000.0;
    if let Some(id) = (0..layers.count).find(|&id| altitude_m(id) > limit_m) {
        warnings.push(format!(
            "the layer of UAV {id} is {} m above the origin; more than {limit_m} m above home \
             (altitude.highest_above_home_m) no UAV takes off to",
            altitude_m(id)
        ));
    }
    if layers.count > 1 && layers.spacing_m < NEAR_M {
        warnings.push(format!(
            "layers are {} m apart (altitude.spacing_m); real vehicles' heights differ by metres, so give {NEAR_M} m or \
             more",
            layers.spacing_m
        ));
    }
    warnings
}
