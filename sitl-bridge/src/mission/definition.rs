//! A mission that can be flown.

use super::plane::{Plane, Scale};
use firmware_core::actor::Mode;
use firmware_core::gate::{Geofence, GeofenceError, Vector, altitude_layer_mm};
use firmware_core::geometry::{TICKS_PER_U, Vec2};
use firmware_core::observation::HALF_SIDE_LIMIT;
use thiserror::Error;

/// Where no margin is given, the fence stands this far outside the map, u.
pub const DEFAULT_MARGIN_U: f64 = 10.0;

/// A mission, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// The map's south-west corner and the plane around it.
    pub plane: Plane,
    /// Metres in a unit, seconds in a step.
    pub scale: Scale,
    /// Side of the square map, u.
    pub side_u: f64,
    /// Corners of the fence on the map, ticks: at least 3, without repeating the first.
    pub fence: Vec<Vec2>,
    /// How high each UAV flies.
    pub layers: Layers,
    /// What heights are believed and flown.
    pub heights: HeightLimits,
    /// Points of interest on the map, ticks.
    pub pois: Vec<Vec2>,
    /// Seed that all UAVs draw their actions and tie-breakers from.
    pub policy_seed: u64,
    /// How actions are drawn.
    pub mode: Mode,
    /// When step 0 begins, Unix time in ms.
    pub epoch_unix_ms: i64,
}

/// Altitude layers: training lets UAVs pass through each other, so neighbours in id fly at
/// different altitudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers {
    /// Altitude of the lowest layer above the origin, m.
    pub base_m: f64,
    /// Between two layers, m.
    pub spacing_m: f64,
    /// Number of layers, at least 1.
    pub count: u16,
}

/// What heights above home are flown, and how much measured heights may differ. Home is where the vehicle
/// stood when it was armed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightLimits {
    /// Greatest height of a UAV's layer above its home, m.
    pub highest_above_home_m: f64,
    /// Home may lie so much above or below the mission's origin, m.
    pub home_within_m: f64,
    /// After the climb the heights by the estimator and by the GPS may differ by so much, m.
    pub check_m: f64,
}

impl Default for HeightLimits {
    fn default() -> Self {
        Self { highest_above_home_m: 120.0, home_within_m: 20.0, check_m: 7.5 }
    }
}

impl Default for Layers {
    /// Twenty layers with 5 m between two: what the heights of GPS receivers differ by, and 115 m at most.
    fn default() -> Self {
        Self { base_m: 20.0, spacing_m: 5.0, count: 20 }
    }
}

/// UAVs of one altitude layer: the mission has too few.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "UAV {id} has no altitude layer of its own: the mission has {count} (altitude.layers), so it would fly at the \
     height of UAV {}; raise altitude.layers",
    id % count
)]
pub struct SharedLayer {
    /// The UAV's id.
    pub id: u16,
    /// Number of layers.
    pub count: u16,
}

impl Layers {
    /// Checks that UAV `id` shares its layer with no UAV of a lower id.
    ///
    /// # Errors
    /// [`SharedLayer`] when there are no more than `id` layers.
    pub const fn check(&self, id: u16) -> Result<(), SharedLayer> {
        if id < self.count { Ok(()) } else { Err(SharedLayer { id, count: self.count }) }
    }

    /// Whether two UAVs fly at one height.
    #[must_use]
    pub fn are_one(&self, a: u16, b: u16) -> bool {
        a.checked_rem(self.count) == b.checked_rem(self.count)
    }

    /// The altitude of UAV `id` above the origin, mm.
    #[must_use]
    pub fn altitude_mm(&self, id: u16) -> i32 {
        let mm = |m: f64| (m * 1000.0).round();
        altitude_layer_mm(id, mm(self.base_m) as i32, mm(self.spacing_m) as u32, self.count)
    }

    /// The altitude of the highest layer above the origin, m.
    #[must_use]
    pub fn highest_m(&self) -> f64 {
        self.base_m + f64::from(self.count - 1) * self.spacing_m
    }
}

impl Mission {
    /// Half the side of the map, ticks, as the observation takes it.
    #[must_use]
    pub fn half_side(&self) -> i32 {
        ((self.side_u * f64::from(TICKS_PER_U / 2)) as i32).clamp(1, HALF_SIDE_LIMIT)
    }

    /// The fence as the safety gate takes it.
    ///
    /// # Errors
    /// It has too few or too many corners, or its edges cross.
    pub fn gate_fence(&self) -> Result<Geofence, GeofenceError> {
        gate_fence(&self.fence, self.scale)
    }

    /// A point on the map in u to ticks.
    #[must_use]
    pub fn ticks_of_u(x: f64, y: f64) -> Vec2 {
        // The observation's own rounding takes f32; worlds hold their points in it.
        Vec2::from_u(x as f32, y as f32)
    }
}

fn gate_fence(corners: &[Vec2], scale: Scale) -> Result<Geofence, GeofenceError> {
    let mm = |&corner: &Vec2| {
        let place = scale.place(corner);
        Vector::new(place.east_mm.round() as i32, place.north_mm.round() as i32)
    };
    Geofence::polygon(&corners.iter().map(mm).collect::<Vec<_>>())
}

/// The map's square, `margin_u` wider on each side.
#[must_use]
pub fn square_fence(side_u: f64, margin_u: f64) -> Vec<Vec2> {
    let (low, high) = (-margin_u, side_u + margin_u);
    [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| Mission::ticks_of_u(x, y)).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_go_round_with_the_id() {
        let layers = Layers { base_m: 20.0, spacing_m: 3.0, count: 4 };
        assert_eq!([0, 1, 3, 4, 7].map(|id| layers.altitude_mm(id)), [20_000, 23_000, 29_000, 20_000, 29_000]);
        assert!(layers.are_one(0, 4) && !layers.are_one(0, 3));
        assert!(layers.check(3).is_ok());
        let shared = layers.check(6).unwrap_err().to_string();
        assert!(
            shared.contains("the mission has 4 (altitude.layers), so it would fly at the height of UAV 2"),
            "{shared}"
        );
    }

    #[test]
    fn the_usual_layers_stay_below_the_usual_limit() {
        assert!(Layers::default().highest_m() <= HeightLimits::default().highest_above_home_m);
    }
}
