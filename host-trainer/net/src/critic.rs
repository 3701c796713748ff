//! The central critic: the observations of all UAVs, each embedded as in the actor, own
//! embedding beside the mean over all; one value a UAV.

use crate::input::Inputs;
use crate::kernel::{Init, Vectorised, vectorised};
use crate::layers::{Bias, BlockGradient, Dense, Encoder, EncoderGradient, EncoderPass, Weights};
use crate::matrix::{Activation, Rows};
use crate::parameter_layout::ParameterLayout;

/// A critic's parameters, laid out for the kernel's products.
#[derive(Clone, Debug)]
pub struct CriticNet {
    layout: ParameterLayout,
    encoder: Encoder,
    own: Weights,
    mean: Weights,
    head_bias: Bias,
    output: Dense,
}

impl CriticNet {
    /// A critic of this layout; all parameters are zero until [`Self::load`].
    #[must_use]
    pub fn new(layout: &ParameterLayout) -> Self {
        Self {
            encoder: Encoder::new(layout),
            own: Weights::new(layout, "head own"),
            mean: Weights::new(layout, "head mean"),
            head_bias: Bias::new(layout, "head"),
            output: Dense::new(layout, "output"),
            layout: layout.clone(),
        }
    }

    /// Takes the parameters, as many and in the order of the layout.
    pub fn load(&mut self, values: &[f32]) {
        let layout = &self.layout;
        self.encoder.load(layout, values);
        self.own.load(layout, values);
        self.mean.load(layout, values);
        self.head_bias.load(layout, values);
        self.output.load(layout, values);
    }
}

/// The critic's activations of a micro-batch, a row a UAV, and after the backward pass the
/// gradients by them.
#[derive(Clone, Debug)]
pub struct CriticPass {
    encoder: EncoderPass,
    /// Mean feature, a row a world.
    mean: Rows,
    /// The mean's part of the head before its ReLU, a row a world; then the gradient by it.
    shared: Rows,
    by_mean: Rows,
    head: Rows,
    by_head: Rows,
    values: Rows,
}

impl CriticPass {
    /// For critics of this layout.
    #[must_use]
    pub fn new(layout: &ParameterLayout) -> Self {
        let rows = |name| Rows::new(layout.shape(name).1);
        Self {
            encoder: EncoderPass::new(layout),
            mean: rows("encoder2"),
            by_mean: rows("encoder2"),
            shared: rows("head own"),
            head: rows("head own"),
            by_head: rows("head own"),
            values: rows("output"),
        }
    }

    /// Computes the normalised values.
    pub fn forward(&mut self, net: &CriticNet, inputs: &Inputs) {
        self.encoder.forward(&net.encoder, inputs);
        let feature = &self.encoder.feature;
        self.mean.resize(feature.rows() / inputs.uavs());
        let scale = (inputs.uavs() as f32).recip();
        vectorised(SumOverUavs { rows: feature, uavs: inputs.uavs(), scale, sums: &mut self.mean });
        self.mean.fill_masks();
        net.mean.forward(&self.mean, net.head_bias.init(), Activation::Identity, &mut self.shared);
        self.head.resize(feature.rows());
        vectorised(BroadcastToUavs { rows: &mut self.head, uavs: inputs.uavs(), scale: None, shared: &self.shared });
        net.own.forward(feature, Init::Accumulate, Activation::Relu, &mut self.head);
        net.output.forward(&self.head, Activation::Identity, &mut self.values);
    }

    /// Adds the gradient by the parameters to `sum`, after [`Self::forward`] with the same net and
    /// inputs, when [`Self::values_mut`] holds the gradient by the values.
    pub fn backward(&mut self, net: &CriticNet, inputs: &Inputs, sum: &mut CriticGradient) {
        let (feature, by_feature) = (&self.encoder.feature, &mut self.encoder.by_feature);
        let uavs = inputs.uavs();
        self.values.fill_masks();
        sum.output.add_weights(&self.head, &self.values);
        sum.output_bias.add_bias(&self.values);
        net.output.backward(&self.values, Activation::ReluGradient(&self.head), &mut self.by_head);
        vectorised(SumOverUavs { rows: &self.by_head, uavs, scale: 1.0, sums: &mut self.shared });
        self.shared.fill_masks();
        sum.mean.add_weights(&self.mean, &self.shared);
        sum.head_bias.add_bias(&self.shared);
        net.mean.backward(&self.shared, Init::Zero, Activation::Identity, &mut self.by_mean);
        sum.own.add_weights(feature, &self.by_head);
        by_feature.resize(feature.rows());
        let scale = Some((uavs as f32).recip());
        vectorised(BroadcastToUavs { rows: by_feature, uavs, scale, shared: &self.by_mean });
        net.own.backward(&self.by_head, Init::Accumulate, Activation::ReluGradient(feature), by_feature);
        self.encoder.backward(&net.encoder, inputs, &mut sum.encoder);
    }

    /// Multiply-adds in products, those with a zero left out: of a forward and of a
    /// backward pass.
    #[must_use]
    pub fn multiply_adds(&self, inputs: &Inputs) -> [u64; 2] {
        let [forward, backward] = self.encoder.multiply_adds(inputs);
        let (feature, head) = (self.encoder.feature.width() as u64, self.head.width() as u64);
        let (rows, active) = (self.head.rows() as u64, self.head.nonzeros());
        let own = self.encoder.feature.nonzeros() * head;
        let mean = self.mean.rows() as u64 * feature * head;
        [forward + own + mean + active, backward + own + active * feature + 2 * mean + 2 * rows * head]
    }

    /// Normalised values, a row of one a UAV.
    #[must_use]
    pub const fn values(&self) -> &Rows {
        &self.values
    }

    /// Values, to be replaced by the gradient by them.
    pub const fn values_mut(&mut self) -> &mut Rows {
        &mut self.values
    }
}

/// `sums[w] = scale · Σ rows` over the UAVs of world w.
struct SumOverUavs<'a> {
    rows: &'a Rows,
    uavs: usize,
    scale: f32,
    sums: &'a mut Rows,
}

impl Vectorised for SumOverUavs<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let stride = self.rows.stride();
        let worlds = self.rows.values().chunks_exact(stride * self.uavs);
        for (sum, world) in self.sums.values_mut().chunks_exact_mut(stride).zip(worlds) {
            sum.fill(0.0);
            for row in world.chunks_exact(stride) {
                sum.iter_mut().zip(row).for_each(|(s, v)| *s += v);
            }
            sum.iter_mut().for_each(|s| *s *= self.scale);
        }
    }
}

/// Copies the row of each world to all its UAVs, times `scale` if there is one.
struct BroadcastToUavs<'a> {
    rows: &'a mut Rows,
    uavs: usize,
    scale: Option<f32>,
    shared: &'a Rows,
}

impl Vectorised for BroadcastToUavs<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let stride = self.shared.stride();
        let worlds = self.rows.values_mut().chunks_exact_mut(stride * self.uavs);
        for (world, shared) in worlds.zip(self.shared.values().chunks_exact(stride)) {
            for row in world.chunks_exact_mut(stride) {
                match self.scale {
                    None => row.copy_from_slice(shared),
                    Some(scale) => row.iter_mut().zip(shared).for_each(|(r, s)| *r = scale * s),
                }
            }
        }
    }
}

/// Gradient of the loss by a critic's parameters: a sum over samples.
#[derive(Clone, Debug)]
pub struct CriticGradient {
    layout: ParameterLayout,
    encoder: EncoderGradient,
    own: BlockGradient,
    mean: BlockGradient,
    head_bias: BlockGradient,
    output: BlockGradient,
    output_bias: BlockGradient,
}

impl CriticGradient {
    /// Zero, for critics of this layout.
    #[must_use]
    pub fn new(layout: &ParameterLayout) -> Self {
        Self {
            encoder: EncoderGradient::new(layout),
            own: BlockGradient::of_weights(layout, "head own"),
            mean: BlockGradient::of_weights(layout, "head mean"),
            head_bias: BlockGradient::of_bias(layout, "head"),
            output: BlockGradient::of_narrow_weights(layout, "output"),
            output_bias: BlockGradient::of_bias(layout, "output"),
            layout: layout.clone(),
        }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.encoder.clear();
        for g in [&mut self.own, &mut self.mean, &mut self.head_bias, &mut self.output, &mut self.output_bias] {
            g.clear();
        }
    }

    /// Writes it to a flat vector of the layout.
    pub fn store(&self, out: &mut [f32]) {
        self.encoder.store(&self.layout, out);
        for g in [&self.own, &self.mean, &self.head_bias, &self.output, &self.output_bias] {
            g.store(&self.layout, out);
        }
    }
}
