//! The mission that the tests fly.

use firmware_core::actor::Mode;
use firmware_core::geometry::Vec2;
use sitl_bridge::mission::{HeightLimits, Layers, Mission, Plane, Scale, square_fence};

/// Three PoIs around the middle of a map of 200 u, with a fence 10 u outside of it and eight altitude layers.
pub fn mission() -> Mission {
    Mission {
        plane: Plane::new(47.397_742, 8.545_594, 488.0).unwrap(),
        scale: Scale { unit_m: 2.5, step_ms: 2000 },
        side_u: 200.0,
        fence: square_fence(200.0, 10.0),
        layers: Layers { base_m: 7.0, spacing_m: 1.0, count: 8 },
        heights: HeightLimits::default(),
        pois: vec![Vec2::from_u(97.0, 108.0), Vec2::from_u(104.0, 96.0), Vec2::from_u(118.0, 110.0)],
        policy_seed: 10,
        mode: Mode::Sample,
        epoch_unix_ms: 1_790_000_000_000 - 2000,
    }
}
