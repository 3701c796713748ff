//! Belief maps: what UAVs with memory know of the world, and what they pass on.

use super::known::{Claim, KnownPoi, SEEN_U, poi_position};
use super::local_map::CellColumn;
use super::prior_map::PriorMap;
use crate::plane::{distance, squared_distance, widened};
use crate::world::World;
use firmware_core::geometry::{OBSERVATION_RANGE_U, SPEED_CAP_U};

/// Stands for the step of something that never happened.
const NEVER: u32 = u32::MAX;
/// A UAV that by its last target should be this near, u, and sends nothing, is believed elsewhere.
const EXPECTED_IN_RANGE_U: f64 = 16.0;

/// The last known position and target of a UAV.
#[derive(Clone, Copy, Debug)]
struct PeerState {
    step: u32,
    at: (f64, f64),
    target: (f64, f64),
}

/// The belief of one UAV.
#[derive(Clone, Debug)]
pub(super) struct Belief {
    id: usize,
    target: (f64, f64),
    /// Step at which each PoI was last seen, by this UAV or by one whose belief has reached it.
    last_seen: Vec<u32>,
    /// Cells that some UAV has seen.
    explored: Vec<bool>,
    /// Kernels of the known PoIs summed, by cell.
    density: Vec<f64>,
    /// PoIs whose kernel is in `density`.
    in_density: Vec<bool>,
    /// All UAVs' last known states, by id.
    peers: Vec<PeerState>,
    /// Positions of all PoIs, to be read only for those seen.
    poi_positions: Vec<(f64, f64)>,
}

impl Belief {
    fn new(id: usize, world: &World, map: &PriorMap) -> Self {
        let (n, p, cells) = (world.scenario().uavs, world.scenario().pois, map.cells() * map.cells());
        let at = widened(world.position(id));
        Self {
            id,
            target: at,
            last_seen: vec![NEVER; p],
            explored: vec![false; cells],
            density: vec![0.0; cells],
            in_density: vec![false; p],
            peers: vec![PeerState { step: NEVER, at, target: at }; n],
            poi_positions: (0..p).map(|p| poi_position(world, p)).collect(),
        }
    }

    /// Takes in what the UAV sees in the present state.
    fn observe(&mut self, world: &World, map: &PriorMap) {
        let (x, y) = world.position(self.id);
        let now = world.steps_done();
        for p in world.pois_within(x, y, OBSERVATION_RANGE_U as f32) {
            self.last_seen[p] = now;
        }
        let at = widened((x, y));
        for a in map.span(at.0, SEEN_U) {
            for b in map.span(at.1, SEEN_U) {
                if squared_distance(map.centre((a, b)), at) <= SEEN_U * SEEN_U {
                    self.explored[a * map.cells() + b] = true;
                }
            }
        }
        self.peers[self.id] = PeerState { step: now, at, target: self.target };
    }

    /// Merges another UAV's belief into this one: the newer of each entry wins.
    fn merge(&mut self, other: &Self) {
        for (own, &received) in self.last_seen.iter_mut().zip(&other.last_seen) {
            if newer(received, *own) {
                *own = received;
            }
        }
        self.explored.iter_mut().zip(&other.explored).for_each(|(own, received)| *own |= received);
        for (k, (own, received)) in self.peers.iter_mut().zip(&other.peers).enumerate() {
            if k != self.id && newer(received.step, own.step) {
                *own = *received;
            }
        }
    }

    /// Adds the kernels of newly known PoIs to the density.
    fn update_density(&mut self, map: &PriorMap) {
        for p in 0..self.in_density.len() {
            if self.last_seen[p] != NEVER && !std::mem::replace(&mut self.in_density[p], true) {
                for (c, density) in self.density.iter_mut().enumerate() {
                    *density += map.kernel(p, (c / map.cells(), c % map.cells()));
                }
            }
        }
    }

    /// Lists the known PoIs and the other UAVs' claims at step `now`.
    pub(super) fn list_known(&self, now: u32, pois: &mut Vec<KnownPoi>, claims: &mut Vec<Claim>) {
        /// Weight that the weight of a PoI out of sight decays to.
        const OLD: f64 = 0.5;
        /// Time constant of that decay, steps.
        const DECAY_STEPS: f64 = 20.0;
        pois.clear();
        for (p, &seen) in self.last_seen.iter().enumerate().filter(|(_, s)| **s != NEVER) {
            let age = f64::from(now - seen);
            let weight = if age > 2.0 { OLD + (1.0 - OLD) * libm::exp(-(age - 2.0) / DECAY_STEPS) } else { 1.0 };
            pois.push(KnownPoi { at: self.poi_positions[p], index: Some(p), weight });
        }
        claims.clear();
        for (id, &PeerState { step, at, target }) in self.peers.iter().enumerate() {
            if id != self.id && step != NEVER {
                let age = f64::from(now - step);
                let flight = (distance(at, target) / f64::from(SPEED_CAP_U) - age).max(0.0);
                claims.push(Claim { id, flight, target, age, yields: false });
            }
        }
    }

    /// Drops the states of UAVs that should be in range by now and sent nothing.
    fn drop_missing(&mut self, now: u32, own: (f64, f64)) {
        for (id, peer) in self.peers.iter_mut().enumerate() {
            let PeerState { step, at, target } = *peer;
            if id == self.id || step == NEVER || step == now {
                continue;
            }
            let (flown, far) = (f64::from(now - step) * f64::from(SPEED_CAP_U), distance(at, target));
            let k = if far <= flown { 1.0 } else { flown / far };
            let predicted = (at.0 + k * (target.0 - at.0), at.1 + k * (target.1 - at.1));
            if squared_distance(predicted, own) < EXPECTED_IN_RANGE_U * EXPECTED_IN_RANGE_U {
                peer.step = NEVER;
            }
        }
    }

    /// Where the UAV flies, u.
    pub(super) fn target(&self) -> (f64, f64) {
        self.target
    }

    /// Changes where the UAV flies, u.
    pub(super) fn set_target(&mut self, target: (f64, f64)) {
        self.target = target;
    }

    /// Writes density and explored cells of a column.
    pub(super) fn fill_column(&self, map: &PriorMap, column: CellColumn<'_>) {
        let cells = column.a * map.cells() + column.rows.start..column.a * map.cells() + column.rows.end;
        column.density.copy_from_slice(&self.density[cells.clone()]);
        column.explored.copy_from_slice(&self.explored[cells]);
    }
}

fn newer(received: u32, own: u32) -> bool {
    received != NEVER && (own == NEVER || received > own)
}

/// The beliefs of all UAVs of a world.
#[derive(Clone, Debug, Default)]
pub(super) struct Beliefs {
    beliefs: Vec<Belief>,
    /// What each UAV sends in this step.
    sent: Vec<Belief>,
}

impl Beliefs {
    /// A step: every UAV observes, sends its belief to its neighbours (one hop) and merges what it receives.
    pub(super) fn update(&mut self, world: &World, map: &PriorMap) {
        if self.beliefs.is_empty() {
            self.beliefs = (0..world.scenario().uavs).map(|i| Belief::new(i, world, map)).collect();
        }
        self.beliefs.iter_mut().for_each(|belief| belief.observe(world, map));
        self.sent.clone_from(&self.beliefs);
        let now = world.steps_done();
        for (i, belief) in self.beliefs.iter_mut().enumerate() {
            for &j in world.neighbours(i) {
                belief.merge(&self.sent[usize::from(j)]);
            }
            belief.update_density(map);
            belief.drop_missing(now, widened(world.position(i)));
        }
    }

    /// The belief of UAV `i`.
    pub(super) fn of(&self, i: usize) -> &Belief {
        &self.beliefs[i]
    }

    /// The belief of UAV `i`, to change.
    pub(super) fn of_mut(&mut self, i: usize) -> &mut Belief {
        &mut self.beliefs[i]
    }
}
