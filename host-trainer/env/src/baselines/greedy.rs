//! The one-step greedy policy with a perfect model.

use crate::policy::Policy;
use crate::world::{World, near_border, step_energy, uav_reward};
use firmware_core::action::Action;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, COVERAGE_RANGE_U};

/// Each UAV takes the action that would earn it the highest reward in the next state if
/// all others stayed where they are; of equal actions the first. It knows the whole
/// model: PoIs, UAVs and groups. All choose at the same time.
#[derive(Clone, Debug, Default)]
pub struct Greedy {
    /// PoIs that each UAV covers, one UAV after another.
    covered: Vec<u32>,
    /// Where each UAV's PoIs begin in `covered`, and the end.
    covered_starts: Vec<usize>,
    /// Number of the last evaluation that visited each PoI and each UAV.
    poi_visited: Vec<u64>,
    uav_visited: Vec<u64>,
    /// Number of the present evaluation of one action.
    evaluation: u64,
    /// UAVs visited whose neighbours are still to be visited.
    queue: Vec<usize>,
}

impl Greedy {
    /// A policy for any world; it draws no random numbers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn list_covered(&mut self, world: &World) {
        self.covered.clear();
        self.covered_starts.clear();
        for (&x, &y) in world.x().iter().zip(world.y()) {
            self.covered_starts.push(self.covered.len());
            self.covered.extend(world.pois_within(x, y, COVERAGE_RANGE_U as f32).map(|p| p as u32));
        }
        self.covered_starts.push(self.covered.len());
    }

    /// Reward of UAV `i` if it alone moved, to (x, y) with this energy.
    fn reward_at(&mut self, world: &World, i: usize, (x, y): (f32, f32), energy: f32) -> f32 {
        self.evaluation += 1;
        let evaluation = self.evaluation;
        self.uav_visited[i] = evaluation;
        self.queue.clear();
        let (mut size, mut group, mut individual) = (1, 0, 0);
        for j in world.uavs_within(x, y, COMMUNICATION_RANGE_U as f32) {
            if self.uav_visited[j] != evaluation {
                self.uav_visited[j] = evaluation;
                self.queue.push(j);
            }
        }
        while let Some(j) = self.queue.pop() {
            size += 1;
            for &p in &self.covered[self.covered_starts[j]..self.covered_starts[j + 1]] {
                if self.poi_visited[p as usize] != evaluation {
                    self.poi_visited[p as usize] = evaluation;
                    group += 1;
                }
            }
            for &k in world.neighbours(j) {
                let k = usize::from(k);
                if self.uav_visited[k] != evaluation {
                    self.uav_visited[k] = evaluation;
                    self.queue.push(k);
                }
            }
        }
        for p in world.pois_within(x, y, COVERAGE_RANGE_U as f32) {
            individual += u32::from(self.poi_visited[p] != evaluation);
        }
        let near = near_border(world.scenario().side_u, x, y);
        uav_reward(individual, group + individual, size, near, energy)
    }
}

impl Policy for Greedy {
    fn act(&mut self, world: &World, actions: &mut [Action]) {
        let side = world.scenario().side_u;
        self.poi_visited.resize(world.scenario().pois, 0);
        self.uav_visited.resize(actions.len(), 0);
        self.list_covered(world);
        for (i, best) in actions.iter_mut().enumerate() {
            let (x, y) = world.position(i);
            let mut most = f32::NEG_INFINITY;
            for action in Action::all() {
                let (vx, vy) = action.next_velocity(world.velocity(i));
                let there = ((x + vx).clamp(0.0, side), (y + vy).clamp(0.0, side));
                let reward = self.reward_at(world, i, there, step_energy(vx, vy));
                if reward > most {
                    (most, *best) = (reward, action);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    /// The model is right when a UAV moves and the others cannot.
    #[test]
    fn a_predicted_reward_is_the_one_paid() {
        let mut world = World::new(&Scenario { side_u: 60.0, ..Scenario::default() }).unwrap();
        for index in 0..20 {
            world.reset(3, index);
            let mut greedy = Greedy::new();
            let mut actions = vec![Action::COAST; 20];
            greedy.act(&world, &mut actions);
            let mover = index as usize;
            let (x, y) = world.position(mover);
            let (vx, vy) = actions[mover].next_velocity((0.0, 0.0));
            let there = ((x + vx).clamp(0.0, 60.0), (y + vy).clamp(0.0, 60.0));
            let predicted = greedy.reward_at(&world, mover, there, step_energy(vx, vy));
            let mut alone = vec![Action::COAST; 20];
            alone[mover] = actions[mover];
            world.step(&alone);
            assert!((world.rewards()[mover] - predicted).abs() < 1e-4, "world {index}");
        }
    }
}
