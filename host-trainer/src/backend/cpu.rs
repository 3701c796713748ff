//! The networks on the CPU.

use super::interface::{Backend, Collection};
use super::workspace::Workspace;
use crate::optim::{Learner, LossSums, PpoLoss, RolloutBatch, WorldStep, count_samples};
use crate::rollout::{RolloutWorker, Workers};
use covey_net::{ActorCritic, EngineError, Inputs, ParameterLayout};

/// The networks of `covey_net` on the CPU's threads. Each of the run's shards collects its
/// worlds' rollouts, and computes its part of every minibatch, on one thread from start to end.
pub struct CpuBackend {
    /// One a shard, as are the next.
    workspaces: Vec<Workspace>,
    gradients: Vec<ActorCritic<Vec<f32>>>,
}

impl CpuBackend {
    /// For networks of these layouts, which take `inputs` like these, in `shards` parts.
    pub fn new(layouts: &ActorCritic<ParameterLayout>, inputs: &Inputs, shards: usize) -> Self {
        let gradients = layouts.as_ref().map(|layout| vec![0.0; layout.len()]);
        Self {
            workspaces: (0..shards).map(|_| Workspace::new(layouts, inputs.clone())).collect(),
            gradients: vec![gradients; shards],
        }
    }
}

impl Backend for CpuBackend {
    fn name(&self) -> String {
        "cpu".to_owned()
    }

    /// The learner's own networks are those that it computes with.
    fn load_parameters(&mut self, _: &Learner) {}

    fn collect(
        &mut self,
        learner: &Learner,
        collection: &Collection<'_>,
        rollout_workers: &mut [RolloutWorker],
        threads: &Workers,
    ) -> Result<(), EngineError> {
        let Collection { settings, value_norm, cloning } = collection;
        let items = rollout_workers.iter_mut().zip(&mut self.workspaces).collect();
        threads.run(items, |_, (worker, workspace): (&mut RolloutWorker, &mut Workspace)| {
            worker.begin_rollout();
            for t in 0..=worker.buffer().steps() {
                workspace.act(learner, worker, t, value_norm);
                worker.advance(t, settings, *cloning);
            }
        });
        Ok(())
    }

    fn begin_update(&mut self, _: &RolloutBatch<'_>) {}

    fn minibatch_gradient(
        &mut self,
        learner: &Learner,
        rollout: &RolloutBatch<'_>,
        loss: &PpoLoss,
        minibatch: &mut [WorldStep],
        threads: &Workers,
    ) -> Result<LossSums, EngineError> {
        // The sort is stable, so it changes nothing where all worlds are of one size.
        minibatch.sort_by_key(|w| w.uavs);
        let (samples, parts, len) = (count_samples(minibatch), self.workspaces.len(), minibatch.len());
        let slices = (0..parts).map(|p| &minibatch[p * len / parts..(p + 1) * len / parts]);
        let items = slices.zip(self.workspaces.iter_mut().zip(&mut self.gradients)).collect();
        let parts = threads.run(items, |_, (world_steps, (workspace, gradient)): (_, (&mut Workspace, _))| {
            workspace.clear_gradients();
            let sums = workspace.accumulate(learner, rollout, loss, world_steps, samples);
            workspace.store_gradients(learner, gradient);
            sums
        });
        let mut sums = LossSums::default();
        parts.iter().for_each(|part| sums.add(part));
        Ok(sums)
    }

    fn partial_gradients(&mut self) -> &mut [ActorCritic<Vec<f32>>] {
        &mut self.gradients
    }

    fn start_counting(&mut self) {
        self.workspaces.iter_mut().for_each(|w| w.multiply_adds = Some(0));
    }

    fn take_count(&mut self) -> u64 {
        self.workspaces.iter_mut().filter_map(|w| w.multiply_adds.take()).sum()
    }
}
