//! The flights of a world as episodes that play in the page.

use crate::simulation::settings::Simulation;
use crate::simulation::world_flight::WorldFlight;
use covey_env::{ActorPolicy, Frame as EnvFrame, Trace, World, policy_seed};
use covey_report::report::{Episode, Frame};
use firmware_core::action::Action;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, COVERAGE_RANGE_U, OBSERVATION_RANGE_U, State};

/// The flight as the nodes measured it.
pub(super) fn flown(index: u64, world: &World, flight: &WorldFlight) -> Episode {
    let pois: Vec<_> = world.poi_x().iter().zip(world.poi_y()).map(|(&x, &y)| [x, y]).collect();
    let place = |state: &Option<State>| {
        state.map_or([f32::NAN; 2], |state| {
            let (x, y) = state.position.to_u();
            [x, y]
        })
    };
    let frame = |(step, row): (usize, &Vec<Option<State>>)| {
        let uavs: Vec<[f32; 2]> = row.iter().map(place).collect();
        let near = |poi: &[f32; 2]| uavs.iter().any(|uav| within(*uav, *poi, COVERAGE_RANGE_U));
        let covered: Vec<bool> = pois.iter().map(near).collect();
        let coverage = match step.checked_sub(1).and_then(|done| flight.coverage.get(done)) {
            Some(&share) => share as f32,
            None => covered.iter().filter(|&&c| c).count() as f32 / pois.len().max(1) as f32,
        };
        let actions =
            step.checked_sub(1).and_then(|done| flight.decisions.get(done)).map_or_else(Vec::new, |decisions| {
                let all: Option<Vec<u8>> = decisions.iter().map(|d| d.map(|d| d.action)).collect();
                all.unwrap_or_default()
            });
        Frame { edges: edges(flight, step, &uavs), uavs, covered, coverage, actions }
    };
    Episode {
        action_names: Action::all().map(action_name).collect(),
        frames: flight.states.iter().enumerate().map(frame).collect(),
        ..episode(format!("World {index}, flown"), world, pois.clone())
    }
}

/// Pairs of UAVs that heard each other: the neighbours that decisions rest on; after the last decision,
/// pairs in communication range.
fn edges(flight: &WorldFlight, step: usize, uavs: &[[f32; 2]]) -> Vec<[u16; 2]> {
    let mut edges: Vec<[u16; 2]> = match flight.decisions.get(step) {
        Some(row) => (0u16..)
            .zip(row)
            .flat_map(|(i, decision)| {
                let seen = decision.as_ref().map_or(&[][..], |d| d.neighbours());
                seen.iter().map(move |&j| [i.min(j), i.max(j)]).collect::<Vec<_>>()
            })
            .filter(|edge| usize::from(edge[1]) < uavs.len())
            .collect(),
        None => {
            let ids = 0..uavs.len();
            let pairs = ids.clone().flat_map(|i| ids.clone().skip(i + 1).map(move |j| (i, j)));
            pairs
                .filter(|&(i, j)| within(uavs[i], uavs[j], COMMUNICATION_RANGE_U))
                .map(|(i, j)| [i as u16, j as u16])
                .collect()
        }
    };
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Whether two points are within range; false where one is NaN.
fn within(a: [f32; 2], b: [f32; 2], range_u: i32) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) <= range_u as f32
}

/// The trainer's flight of the same world.
pub(super) fn trained(sim: &Simulation<'_>, index: u64, world: &mut World) -> Episode {
    let mut policy = ActorPolicy::new(sim.actor, policy_seed(sim.seed, index), sim.mode);
    let trace = Trace::record_in(world, &mut policy);
    let pair = |&(x, y): &(f32, f32)| [x, y];
    let frame = |f: &EnvFrame| Frame {
        uavs: f.uavs.iter().map(pair).collect(),
        edges: f.edges.iter().map(|&(a, b)| [a, b]).collect(),
        covered: f.covered.clone(),
        coverage: f.coverage as f32,
        actions: Vec::new(),
    };
    let pois = trace.pois.iter().map(pair).collect();
    Episode {
        frames: trace.frames.iter().map(frame).collect(),
        ..episode(format!("World {index}, trainer's evaluation"), world, pois)
    }
}

fn episode(title: String, world: &World, pois: Vec<[f32; 2]>) -> Episode {
    Episode {
        title,
        side_u: world.scenario().side_u,
        coverage_range_u: COVERAGE_RANGE_U as f32,
        observation_range_u: OBSERVATION_RANGE_U as f32,
        communication_range_u: COMMUNICATION_RANGE_U as f32,
        pois,
        ..Episode::default()
    }
}

/// The name of an action.
fn action_name(action: Action) -> String {
    const DIRECTIONS: [&str; 8] =
        ["east", "south-east", "south", "south-west", "west", "north-west", "north", "north-east"];
    let index = usize::from(action.index());
    match DIRECTIONS.get(index % 8) {
        Some(direction) if index < 16 => format!("{} {direction}", if index < 8 { "4 u/step²" } else { "2 u/step²" }),
        _ => "coast".into(),
    }
}
