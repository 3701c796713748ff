//! The networks on a device, such as a GPU.

use super::device_check::check;
use super::interface::{Backend, Collection};
use crate::optim::{Learner, LossSums, PpoLoss, RolloutBatch, Sample, WorldStep, count_samples};
use crate::rollout::{RolloutWorker, Workers};
use crate::settings::Settings;
use covey_env::ObservationForm;
use covey_net::{ActorCritic, Engine, EngineError, GraphBatch, Outputs, ParameterLayout, Rows};

/// An [`Engine`] with its buffers: all worlds of a step at once, whole minibatches at once. Worlds,
/// sampling, loss and optimiser stay on the CPU.
pub struct DeviceBackend {
    engine: Box<dyn Engine>,
    outputs: Outputs,
    /// First world-step of each worker among those on the device.
    first_world_steps: Vec<u32>,
    samples: Vec<Sample>,
    gradient: ActorCritic<Vec<f32>>,
}

impl DeviceBackend {
    /// For a run with these settings, with the learner's parameters loaded. The device's numbers
    /// for the last state of `worker`'s rollout are compared with the CPU's: a device whose driver
    /// computes something else must not train.
    ///
    /// # Errors
    /// When devices do not take such a run, the device fails, or its numbers are wrong.
    pub fn new(
        mut engine: Box<dyn Engine>,
        s: &Settings,
        layouts: &ActorCritic<ParameterLayout>,
        learner: &Learner,
        worker: &RolloutWorker,
    ) -> Result<Self, EngineError> {
        let requirements = [
            (s.observation == ObservationForm::Compact, "observation = \"compact\""),
            (s.uavs_max == 0, "uavs_max = 0"),
        ];
        if let Some((_, setting)) = requirements.into_iter().find(|(met, _)| !met) {
            return Err(EngineError::Unsupported { device: engine.name(), setting });
        }
        engine.load_parameters(learner.parameters());
        let buffer = worker.buffer();
        check(&mut *engine, buffer.graph_batch(buffer.step(buffer.steps())), layouts, learner)?;
        Ok(Self {
            engine,
            outputs: Outputs::default(),
            first_world_steps: Vec::new(),
            samples: Vec::new(),
            gradient: ActorCritic::default(),
        })
    }
}

impl Backend for DeviceBackend {
    fn name(&self) -> String {
        self.engine.name()
    }

    fn load_parameters(&mut self, learner: &Learner) {
        self.engine.load_parameters(learner.parameters());
    }

    fn collect(
        &mut self,
        _: &Learner,
        collection: &Collection<'_>,
        rollout_workers: &mut [RolloutWorker],
        threads: &Workers,
    ) -> Result<(), EngineError> {
        let Collection { settings, value_norm, cloning } = collection;
        rollout_workers.iter_mut().for_each(RolloutWorker::begin_rollout);
        let steps = settings.rollout_steps as usize;
        for t in 0..=steps {
            let batches: Vec<GraphBatch<'_>> =
                rollout_workers.iter().map(|worker| worker.buffer().graph_batch(worker.buffer().step(t))).collect();
            self.engine.forward(&batches, &mut self.outputs)?;
            let (mut logits, mut values) = (split_rows(&self.outputs.logits), split_rows(&self.outputs.values));
            let items = rollout_workers.iter_mut().map(|worker| {
                let agents = worker.buffer().agents();
                (logits(agents), values(agents), worker)
            });
            threads.run(items.collect(), |_, (logits, values, worker): (&[f32], &[f32], &mut RolloutWorker)| {
                let worlds = 0..worker.buffer().num_envs();
                worker.store_values(t, &worlds, values, value_norm);
                if t < steps {
                    worker.sample_actions(t, worlds, logits);
                }
                worker.advance(t, settings, *cloning);
            });
        }
        Ok(())
    }

    /// Brings the observations of the rollout to the device.
    fn begin_update(&mut self, rollout: &RolloutBatch<'_>) {
        let batches: Vec<GraphBatch<'_>> =
            rollout.buffers().map(|buffer| buffer.graph_batch(0..buffer.steps() * buffer.agents())).collect();
        self.engine.load_rollout(&batches);
        let mut first = 0;
        self.first_world_steps.clear();
        for batch in &batches {
            self.first_world_steps.push(first);
            first += batch.world_steps() as u32;
        }
    }

    fn minibatch_gradient(
        &mut self,
        _: &Learner,
        rollout: &RolloutBatch<'_>,
        loss: &PpoLoss,
        minibatch: &mut [WorldStep],
        _: &Workers,
    ) -> Result<LossSums, EngineError> {
        let on_device = |w: &WorldStep| self.first_world_steps[w.worker as usize] + w.first / w.uavs;
        let world_steps: Vec<u32> = minibatch.iter().map(on_device).collect();
        self.samples.clear();
        self.samples.extend(minibatch.iter().flat_map(|w| rollout.samples(w)));
        let (count, mut sums) = (count_samples(minibatch), LossSums::default());
        let mut backward =
            |out: &mut Outputs| loss.backward(&mut out.logits, &mut out.values, &self.samples, count, &mut sums);
        self.engine.gradient(&world_steps, &mut self.outputs, &mut backward, &mut self.gradient)?;
        Ok(sums)
    }

    fn partial_gradients(&mut self) -> &mut [ActorCritic<Vec<f32>>] {
        std::slice::from_mut(&mut self.gradient)
    }
}

/// Takes rows off the front, with their padding, as many as asked for each time.
fn split_rows<'r>(rows: &'r Rows) -> impl FnMut(usize) -> &'r [f32] {
    let (mut rest, stride) = (rows.values(), rows.stride());
    move |count| {
        let (front, behind) = rest.split_at(count * stride);
        rest = behind;
        front
    }
}
