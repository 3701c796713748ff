//! The networks on a device of burn.

use crate::device::{Kind, NoDevice};
use crate::networks::{Parameters, logits, values};
use crate::packed::Packed;
use burn::tensor::{Device, Tensor, TensorData, Transaction};
use covey_net::{Engine, EngineError, GraphBatch, Outputs, ParameterLayout, Rows};
use firmware_core::actor::Aggregation;

/// Actor and critic on a device.
pub struct BurnEngine {
    device: Device,
    name: String,
    layouts: [ParameterLayout; 2],
    aggregation: Aggregation,
    inputs: usize,
    /// Flat vectors of actor and critic.
    parameters: [Tensor<1>; 2],
    held: Option<Packed>,
}

impl BurnEngine {
    /// For networks of these layouts, of actor and critic, on the first device of a kind; all
    /// parameters are zero until they are loaded.
    ///
    /// # Errors
    /// When there is no such device.
    pub fn open(kind: Kind, layouts: [ParameterLayout; 2], aggregation: Aggregation) -> Result<Self, NoDevice> {
        let (device, name) = kind.open()?;
        let parameters = [0, 1].map(|k: usize| Tensor::zeros([layouts[k].len()], &device));
        let (inputs, _) = layouts[0].shape("encoder1");
        Ok(Self { device, name, layouts, aggregation, inputs, parameters, held: None })
    }

    /// Logits and values with these parameters.
    fn outputs(&self, parameters: &[Tensor<1>; 2], seen: &Packed) -> [Tensor<2>; 2] {
        let batch = seen.unpack(self.inputs);
        let [actor, critic] = [0, 1].map(|k: usize| Parameters::new(&self.layouts[k], &parameters[k]));
        [logits(&actor, self.aggregation, &batch), values(&critic, &batch)]
    }

    /// Brings tensors here.
    fn read<const D: usize>(&self, tensors: [Tensor<D>; 2]) -> Result<[Vec<f32>; 2], EngineError> {
        let failed = |why: String| EngineError::Failed { device: self.name.clone(), why };
        let [a, b] = tensors;
        let data = Transaction::default().register(a).register(b).try_execute().map_err(|e| failed(e.to_string()))?;
        let floats = |d: TensorData| d.try_cast_as::<f32>().map(TensorData::try_into_vec);
        let mut vectors = data.into_iter().map(|d| match floats(d) {
            Ok(Ok(v)) => Ok(v),
            Ok(Err(e)) => Err(failed(format!("{e:?}"))),
            Err(e) => Err(failed(format!("{e:?}"))),
        });
        let mut next = || vectors.next().unwrap_or_else(|| Err(failed("it returned too few tensors".to_owned())));
        Ok([next()?, next()?])
    }
}

impl Engine for BurnEngine {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn load(&mut self, parameters: [&[f32]; 2]) {
        self.parameters = parameters.map(|p| Tensor::from_data(TensorData::from(p), &self.device));
    }

    fn forward(&mut self, seen: &[GraphBatch<'_>], out: &mut Outputs) -> Result<(), EngineError> {
        let outputs = self.outputs(&self.parameters, &Packed::new(seen, &self.device));
        let [logits, values] = self.read(outputs)?;
        fill(&mut out.logits, &logits);
        fill(&mut out.values, &values);
        Ok(())
    }

    fn hold(&mut self, seen: &[GraphBatch<'_>]) {
        // Before the new ones: both may not fit.
        self.held = None;
        self.held = Some(Packed::new(seen, &self.device));
    }

    fn gradient(
        &mut self,
        world_steps: &[u32],
        out: &mut Outputs,
        loss: &mut dyn FnMut(&mut Outputs),
        gradients: &mut [Vec<f32>; 2],
    ) -> Result<(), EngineError> {
        let held = self.held.as_ref().expect("world-steps are held before gradients are asked for");
        let leaves = self.parameters.clone().map(|p| p.autodiff().require_grad());
        let outputs = self.outputs(&leaves, &held.select(world_steps));
        let [logits, values] = self.read(outputs.clone().map(Tensor::inner))?;
        fill(&mut out.logits, &logits);
        fill(&mut out.values, &values);
        loss(out);
        // With the gradient g by an output y, the gradient of Σ g·y is that of the loss.
        let weighted = |output: Tensor<2>, by_output: &Rows| {
            let shape = output.dims();
            (output * Tensor::from_data(TensorData::new(flat(by_output), shape), &self.device)).sum()
        };
        let [logits, values] = outputs;
        let mut found = (weighted(logits, &out.logits) + weighted(values, &out.values)).backward();
        let [actor, critic] = leaves.map(|l| l.grad_remove(&mut found).expect("every parameter has a gradient"));
        *gradients = self.read([actor, critic])?;
        Ok(())
    }
}

/// Takes over numbers that have no padding.
fn fill(rows: &mut Rows, numbers: &[f32]) {
    let (step, width) = (rows.step(), rows.width());
    rows.resize(numbers.len() / width);
    for (row, numbers) in rows.values_mut().chunks_exact_mut(step).zip(numbers.chunks_exact(width)) {
        row[..width].copy_from_slice(numbers);
        row[width..].fill(0.0);
    }
}

/// The numbers without padding.
fn flat(rows: &Rows) -> Vec<f32> {
    (0..rows.rows()).flat_map(|r| rows.row(r)).copied().collect()
}
