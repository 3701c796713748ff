//! The networks on a device of burn.

use crate::device::{Kind, NoDevice};
use crate::networks::{Parameters, logits, values};
use crate::packed::Packed;
use burn::tensor::{Device, Tensor, TensorData, Transaction};
use covey_net::{ActorCritic, Engine, EngineError, GraphBatch, Outputs, ParameterLayout, Rows};
use firmware_core::actor::Aggregation;

/// Actor and critic on a device.
pub struct BurnEngine {
    device: Device,
    name: String,
    layouts: ActorCritic<ParameterLayout>,
    aggregation: Aggregation,
    inputs: usize,
    /// Flat parameter vectors.
    parameters: ActorCritic<Tensor<1>>,
    /// The world-steps of a rollout, for gradients.
    rollout: Option<Packed>,
}

impl BurnEngine {
    /// For networks of these layouts, of actor and critic, on the first device of a kind; all
    /// parameters are zero until they are loaded.
    ///
    /// # Errors
    /// When there is no such device.
    pub fn open(kind: Kind, layouts: ActorCritic<ParameterLayout>, aggregation: Aggregation) -> Result<Self, NoDevice> {
        let (device, name) = kind.open()?;
        let parameters = layouts.as_ref().map(|layout| Tensor::zeros([layout.len()], &device));
        let (inputs, _) = layouts.actor.shape("encoder1");
        Ok(Self { device, name, layouts, aggregation, inputs, parameters, rollout: None })
    }

    /// Logits, `[rows, 17]`, of the actor and values, `[rows, 1]`, of the critic with these
    /// parameters.
    fn outputs(&self, parameters: &ActorCritic<Tensor<1>>, packed: &Packed) -> ActorCritic<Tensor<2>> {
        let batch = packed.unpack(self.inputs);
        let actor = Parameters::new(&self.layouts.actor, &parameters.actor);
        let critic = Parameters::new(&self.layouts.critic, &parameters.critic);
        ActorCritic { actor: logits(&actor, self.aggregation, &batch), critic: values(&critic, &batch) }
    }

    /// Copies tensors from the device, both in one transaction.
    fn read<const D: usize>(&self, tensors: ActorCritic<Tensor<D>>) -> Result<ActorCritic<Vec<f32>>, EngineError> {
        let failed = |why: String| EngineError::Failed { device: self.name.clone(), why };
        let transaction = Transaction::default().register(tensors.actor).register(tensors.critic);
        let data = transaction.try_execute().map_err(|e| failed(e.to_string()))?;
        let floats = |d: TensorData| d.try_cast_as::<f32>().map(TensorData::try_into_vec);
        let mut vectors = data.into_iter().map(|d| match floats(d) {
            Ok(Ok(v)) => Ok(v),
            Ok(Err(e)) => Err(failed(format!("{e:?}"))),
            Err(e) => Err(failed(format!("{e:?}"))),
        });
        let mut next = || vectors.next().unwrap_or_else(|| Err(failed("it returned too few tensors".to_owned())));
        Ok(ActorCritic { actor: next()?, critic: next()? })
    }
}

impl Engine for BurnEngine {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn load_parameters(&mut self, parameters: ActorCritic<&[f32]>) {
        self.parameters = parameters.map(|p| Tensor::from_data(TensorData::from(p), &self.device));
    }

    fn forward(&mut self, batches: &[GraphBatch<'_>], out: &mut Outputs) -> Result<(), EngineError> {
        let outputs = self.outputs(&self.parameters, &Packed::new(batches, &self.device));
        let outputs = self.read(outputs)?;
        fill(&mut out.logits, &outputs.actor);
        fill(&mut out.values, &outputs.critic);
        Ok(())
    }

    fn load_rollout(&mut self, batches: &[GraphBatch<'_>]) {
        // Before the new ones: both may not fit.
        self.rollout = None;
        self.rollout = Some(Packed::new(batches, &self.device));
    }

    fn gradient(
        &mut self,
        world_steps: &[u32],
        out: &mut Outputs,
        loss: &mut dyn FnMut(&mut Outputs),
        gradients: &mut ActorCritic<Vec<f32>>,
    ) -> Result<(), EngineError> {
        let rollout = self.rollout.as_ref().expect("a rollout is loaded before gradients are asked for");
        let leaves = self.parameters.clone().map(|p| p.autodiff().require_grad());
        let outputs = self.outputs(&leaves, &rollout.select(world_steps));
        let numbers = self.read(outputs.clone().map(Tensor::inner))?;
        fill(&mut out.logits, &numbers.actor);
        fill(&mut out.values, &numbers.critic);
        loss(out);
        // With the gradient g by an output y, the gradient of Σ g·y is that of the loss.
        let weighted_sum = |output: Tensor<2>, by_output: &Rows| {
            let shape = output.dims();
            (output * Tensor::from_data(TensorData::new(flat(by_output), shape), &self.device)).sum()
        };
        let total = weighted_sum(outputs.actor, &out.logits) + weighted_sum(outputs.critic, &out.values);
        let mut by_leaf = total.backward();
        *gradients = self.read(leaves.map(|l| l.grad_remove(&mut by_leaf).expect("every parameter has a gradient")))?;
        Ok(())
    }
}

/// Overwrites rows by numbers that have no padding.
fn fill(rows: &mut Rows, numbers: &[f32]) {
    let (step, width) = (rows.stride(), rows.width());
    rows.resize(numbers.len() / width);
    for (row, numbers) in rows.values_mut().chunks_exact_mut(step).zip(numbers.chunks_exact(width)) {
        row[..width].copy_from_slice(numbers);
        row[width..].fill(0.0);
    }
}

/// The numbers of rows without their padding.
fn flat(rows: &Rows) -> Vec<f32> {
    (0..rows.rows()).flat_map(|r| rows.row(r)).copied().collect()
}
