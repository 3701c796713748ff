//! A world of the scenario as a mission.

use super::definition::{DEFAULT_MARGIN_U, HeightLimits, Layers, Mission, square_fence};
use super::file::Origin;
use super::plane::{OriginError, Plane, Scale};
use covey_env::World;
use firmware_core::actor::Mode;
use firmware_core::geometry::Vec2;
use firmware_core::neighbour_table::DEFAULT_STEP_MS;

impl Mission {
    /// The mission of a world: its PoIs on a map at `origin`, all else as where a file leaves
    /// it out.
    ///
    /// # Errors
    /// When no map can be laid there.
    pub fn of_world(world: &World, origin: Origin) -> Result<Self, OriginError> {
        let side_u = f64::from(world.scenario().side_u);
        Ok(Self {
            plane: Plane::new(origin.lat, origin.lon, origin.alt_m)?,
            scale: Scale { unit_m: 2.5, step_ms: DEFAULT_STEP_MS },
            side_u,
            fence: square_fence(side_u, DEFAULT_MARGIN_U),
            layers: Layers::default(),
            heights: HeightLimits::default(),
            pois: world.poi_x().iter().zip(world.poi_y()).map(|(&x, &y)| Vec2::from_u(x, y)).collect(),
            policy_seed: 10,
            mode: Mode::Sample,
            epoch_unix_ms: 0,
        })
    }
}
