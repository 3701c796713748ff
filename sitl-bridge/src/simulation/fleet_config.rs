//! The configuration of the fleet of simulated autopilots, as `docs/simlink.md` describes it.

use super::settings::{START_UNIX_MS, Simulation};
use crate::mission::Mission;
use covey_env::World;
use serde_json::{Value, json};
use std::path::Path;

/// An epoch so far ahead that no step starts before the fleet is told the real one, ms.
const FAR_AHEAD_MS: i64 = 1_000_000_000_000;

/// The configuration of real autopilots for `world`, whose files are in `folder`.
pub(super) fn real_fleet_config(
    sim: &Simulation<'_>,
    world: &World,
    mission: &Mission,
    ports: &[u16],
    folder: &Path,
) -> Value {
    let mut config = common(world, mission, ports);
    config["autopilot"] = sim.autopilots.name().into();
    config["program"] = sim.autopilots.build().map(|path| path.to_string_lossy()).into();
    config["folder"] = folder.to_string_lossy().into();
    config["speed"] = sim.speed.unwrap_or(1.0).into();
    config
}

/// What both kinds of fleet are told: vehicles on their pads, and the map.
fn common(world: &World, mission: &Mission, ports: &[u16]) -> Value {
    let (lat, lon) = mission.plane.origin_degrees();
    let alt = f64::from(mission.plane.alt_mm) / 1000.0;
    let vehicle = |(id, &port): (usize, &u16)| {
        let (x, y) = world.position(id);
        json!({"id": id, "system": id + 1, "host": "127.0.0.1", "port": port, "start_u": [x, y]})
    };
    json!({
        "vehicles": ports.iter().enumerate().map(vehicle).collect::<Vec<_>>(),
        "origin": {"lat": lat, "lon": lon, "alt": alt},
        "scale_m": mission.scale.unit_m,
        "step_ms": mission.scale.step_ms,
        "epoch_unix_ms": START_UNIX_MS + FAR_AHEAD_MS,
    })
}

/// The configuration of simlink for `world`: one vehicle for each port, which runs at `bring_up_speed` times real
/// time until all stream.
pub(super) fn fleet_config(
    sim: &Simulation<'_>,
    world: &World,
    mission: &Mission,
    ports: &[u16],
    bring_up_speed: f64,
) -> Value {
    let mut config = common(world, mission, ports);
    let dialect = if sim.px4 { "px4" } else { "ardupilot" };
    for vehicle in config["vehicles"].as_array_mut().into_iter().flatten() {
        vehicle["dialect"] = dialect.into();
    }
    // The failsafe that watches the nodes, each by its own system.
    let watched = json!({"FS_GCS_ENABLE": 1, "MAV_GCS_SYSID": 1, "MAV_GCS_SYSID_HI": 254});
    let own = json!({
        "parameters": if sim.px4 { json!({}) } else { watched },
        "map_side_u": mission.side_u,
        "rate_hz": sim.rate_hz,
        "dynamics": if sim.ideal { "ideal" } else { "point" },
        "lockstep": sim.speed.is_none(),
        "speed": sim.speed.unwrap_or(bring_up_speed),
        "seed": sim.seed,
        "signing_key_file": sim.key_file,
        "unix_ms": START_UNIX_MS,
    });
    for (name, value) in own.as_object().into_iter().flatten() {
        config[name] = value.clone();
    }
    for (name, value) in &sim.fleet {
        config[name] = value.clone();
    }
    config
}
