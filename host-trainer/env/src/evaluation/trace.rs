//! Recorded episodes, for reports.

use super::rollout::rollout;
use crate::policy::Policy;
use crate::scenario::{Scenario, ScenarioError};
use crate::world::{EpisodeMetrics, World};
use serde::Serialize;

/// A recorded episode of one world: the spawn state and the state after every step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trace {
    /// The scenario of the world.
    pub scenario: Scenario,
    /// Positions of the PoIs, (east, north) in u.
    pub pois: Vec<(f32, f32)>,
    /// The spawn state, which no metric counts, then the state after each step.
    pub frames: Vec<Frame>,
    /// Metrics of the episode.
    pub metrics: EpisodeMetrics,
}

/// One state of a [`Trace`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// Positions of the UAVs, (east, north) in u.
    pub uavs: Vec<(f32, f32)>,
    /// Edges of the communication graph: pairs of UAVs in range of each other, the lower id first, in ascending order.
    pub edges: Vec<(u16, u16)>,
    /// Whether any UAV covers each PoI.
    pub covered: Vec<bool>,
    /// Share of the PoIs that is covered, 0 to 1.
    pub coverage: f64,
}

impl Trace {
    /// Records `policy` in world `index` of `seed`.
    ///
    /// # Errors
    /// [`ScenarioError`] when the scenario is not valid.
    pub fn record<P: Policy + ?Sized>(
        scenario: &Scenario,
        seed: u64,
        index: u64,
        policy: &mut P,
    ) -> Result<Self, ScenarioError> {
        let mut world = World::new(scenario)?;
        world.reset(seed, index);
        Ok(Self::record_in(&mut world, policy))
    }

    /// Records `policy` in `world`, from its present spawn state to the end of the episode.
    pub fn record_in<P: Policy + ?Sized>(world: &mut World, policy: &mut P) -> Self {
        let mut frames = Vec::with_capacity(world.scenario().steps as usize + 1);
        rollout(world, policy, |world| frames.push(Frame::of(world)));
        Self {
            scenario: world.scenario().clone(),
            pois: pairs(world.poi_x(), world.poi_y()),
            frames,
            metrics: world.metrics(),
        }
    }
}

impl Frame {
    fn of(world: &World) -> Self {
        let pois = world.scenario().pois;
        Self {
            uavs: pairs(world.x(), world.y()),
            edges: edges(world),
            covered: (0..pois).map(|p| world.poi_is_covered(p)).collect(),
            coverage: world.covered() as f64 / pois as f64,
        }
    }
}

fn edges(world: &World) -> Vec<(u16, u16)> {
    let mut edges = Vec::new();
    for i in 0..world.scenario().uavs {
        let i16 = i as u16;
        edges.extend(world.neighbours(i).iter().filter(|&&j| i16 < j).map(|&j| (i16, j)));
    }
    edges.sort_unstable();
    edges
}

fn pairs(x: &[f32], y: &[f32]) -> Vec<(f32, f32)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::Centroid;

    #[test]
    fn a_trace_agrees_with_the_metrics() {
        let scenario = Scenario { steps: 30, ..Scenario::default() };
        let trace = Trace::record(&scenario, 777, 3, &mut Centroid::new(1, 3)).unwrap();
        assert_eq!(trace.frames.len(), 31);
        let scored = &trace.frames[1..];
        let mean = scored.iter().map(|f| f.coverage).sum::<f64>() / 30.0;
        assert!((mean - trace.metrics.coverage).abs() < 1e-12);
        for frame in &trace.frames {
            let covered = frame.covered.iter().filter(|&&c| c).count();
            assert_eq!(covered as f64 / 120.0, frame.coverage);
            for &(i, j) in &frame.edges {
                let (a, b) = (frame.uavs[usize::from(i)], frame.uavs[usize::from(j)]);
                assert!(i < j && (a.0 - b.0).hypot(a.1 - b.1) <= 18.001);
            }
        }
    }
}
