//! Coverage of PoIs from given positions.

use covey_env::World;
use serde_json::Value;

/// Share of PoIs that any UAV covers.
pub(super) fn covered_share(world: &World) -> f64 {
    world.covered() as f64 / world.scenario().pois as f64
}

/// Share of PoIs covered from positions in a `truth` event of the fleet, u.
pub(super) fn true_share(world: &World, positions: &Value) -> Option<f64> {
    let places: Option<Vec<(f32, f32)>> = positions
        .as_array()?
        .iter()
        .map(|place| Some((place[0].as_f64()? as f32, place[1].as_f64()? as f32)))
        .collect();
    share_at(world, &places?)
}

/// Share of PoIs covered from these positions, u; a position outside the map counts as one on its edge.
pub(super) fn share_at(world: &World, places: &[(f32, f32)]) -> Option<f64> {
    let side = world.scenario().side_u;
    let inside: Vec<_> = places.iter().map(|&(x, y)| (x.clamp(0.0, side), y.clamp(0.0, side))).collect();
    let pois: Vec<_> = world.poi_x().iter().copied().zip(world.poi_y().iter().copied()).collect();
    let mut scene = world.clone();
    scene.set_positions(&inside, &pois).ok()?;
    Some(covered_share(&scene))
}
