//! The central critic: the observations of all UAVs, each embedded as in the actor, own
//! embedding beside the mean over all; one value a UAV.

use crate::dense::{Bias, Dense, Gradient, Weights};
use crate::encoder::{Encoder, EncoderGradient, EncoderPass};
use crate::inputs::Inputs;
use crate::kernel::{Vectorised, vectorised};
use crate::matrix::{From, Rows, To};
use crate::parameter_layout::ParameterLayout;

/// A critic's parameters as products read them.
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
    /// For this layout, of a critic; all zeros until [`Self::load`].
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

    /// Takes the parameters.
    pub fn load(&mut self, values: &[f32]) {
        let layout = &self.layout;
        self.encoder.load(layout, values);
        self.own.load(layout, values);
        self.mean.load(layout, values);
        self.head_bias.load(layout, values);
        self.output.load(layout, values);
    }
}

/// Everything between observations and values, a row a UAV; then the way back.
#[derive(Clone, Debug)]
pub struct CriticPass {
    encoder: EncoderPass,
    /// Mean feature, a row a world.
    mean: Rows,
    /// What a world's UAVs share before the head's ReLU, and its gradient.
    shared: Rows,
    by_mean: Rows,
    head: Rows,
    by_head: Rows,
    values: Rows,
}

impl CriticPass {
    /// For this layout, of a critic.
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

    /// Computes the values.
    pub fn forward(&mut self, net: &CriticNet, inputs: &Inputs) {
        self.encoder.forward(&net.encoder, inputs);
        let feature = &self.encoder.feature;
        self.mean.resize(feature.rows() / inputs.uavs());
        let scale = (inputs.uavs() as f32).recip();
        vectorised(SumWorlds { rows: feature, uavs: inputs.uavs(), scale, sums: &mut self.mean });
        self.mean.mark_all();
        net.mean.forward(&self.mean, net.head_bias.start(), To::Plain, &mut self.shared);
        self.head.resize(feature.rows());
        vectorised(Share { rows: &mut self.head, uavs: inputs.uavs(), scale: None, shared: &self.shared });
        net.own.forward(feature, From::Kept, To::Relu, &mut self.head);
        net.output.forward(&self.head, To::Plain, &mut self.values);
    }

    /// Adds the gradient of the parameters to `sum`, after [`Self::forward`] with the same
    /// net and inputs, when [`Self::values_mut`] holds the gradient by the values.
    pub fn backward(&mut self, net: &CriticNet, inputs: &Inputs, sum: &mut CriticGradient) {
        let (feature, by_feature) = (&self.encoder.feature, &mut self.encoder.by_feature);
        let uavs = inputs.uavs();
        self.values.mark_all();
        sum.output.add_weights(&self.head, &self.values);
        sum.output_bias.add_bias(&self.values);
        net.output.backward(&self.values, To::Gate(&self.head), &mut self.by_head);
        vectorised(SumWorlds { rows: &self.by_head, uavs, scale: 1.0, sums: &mut self.shared });
        self.shared.mark_all();
        sum.mean.add_weights(&self.mean, &self.shared);
        sum.head_bias.add_bias(&self.shared);
        net.mean.backward(&self.shared, From::Zero, To::Plain, &mut self.by_mean);
        sum.own.add_weights(feature, &self.by_head);
        by_feature.resize(feature.rows());
        let scale = Some((uavs as f32).recip());
        vectorised(Share { rows: by_feature, uavs, scale, shared: &self.by_mean });
        net.own.backward(&self.by_head, From::Kept, To::Gate(feature), by_feature);
        self.encoder.backward(&net.encoder, inputs, &mut sum.encoder);
    }

    /// Multiply-adds in products, those with a zero left out: of a forward and of a
    /// backward pass.
    #[must_use]
    pub fn work(&self, inputs: &Inputs) -> [u64; 2] {
        let [forward, backward] = self.encoder.work(inputs);
        let (feature, head) = (self.encoder.feature.width() as u64, self.head.width() as u64);
        let (rows, active) = (self.head.rows() as u64, self.head.marked());
        let own = self.encoder.feature.marked() * head;
        let mean = self.mean.rows() as u64 * feature * head;
        [forward + own + mean + active, backward + own + active * feature + 2 * mean + 2 * rows * head]
    }

    /// Normalised values, 1 wide.
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
struct SumWorlds<'a> {
    rows: &'a Rows,
    uavs: usize,
    scale: f32,
    sums: &'a mut Rows,
}

impl Vectorised for SumWorlds<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let step = self.rows.step();
        let worlds = self.rows.values().chunks_exact(step * self.uavs);
        for (sum, world) in self.sums.values_mut().chunks_exact_mut(step).zip(worlds) {
            sum.fill(0.0);
            for row in world.chunks_exact(step) {
                sum.iter_mut().zip(row).for_each(|(s, v)| *s += v);
            }
            sum.iter_mut().for_each(|s| *s *= self.scale);
        }
    }
}

/// Gives every UAV the row of its world, scaled if asked for.
struct Share<'a> {
    rows: &'a mut Rows,
    uavs: usize,
    scale: Option<f32>,
    shared: &'a Rows,
}

impl Vectorised for Share<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let step = self.shared.step();
        let worlds = self.rows.values_mut().chunks_exact_mut(step * self.uavs);
        for (world, shared) in worlds.zip(self.shared.values().chunks_exact(step)) {
            for row in world.chunks_exact_mut(step) {
                match self.scale {
                    None => row.copy_from_slice(shared),
                    Some(scale) => row.iter_mut().zip(shared).for_each(|(r, s)| *r = scale * s),
                }
            }
        }
    }
}

/// Gradient of a critic's parameters: sums over samples.
#[derive(Clone, Debug)]
pub struct CriticGradient {
    layout: ParameterLayout,
    encoder: EncoderGradient,
    own: Gradient,
    mean: Gradient,
    head_bias: Gradient,
    output: Gradient,
    output_bias: Gradient,
}

impl CriticGradient {
    /// Zero, for this layout of a critic.
    #[must_use]
    pub fn new(layout: &ParameterLayout) -> Self {
        Self {
            encoder: EncoderGradient::new(layout),
            own: Gradient::of_weights(layout, "head own"),
            mean: Gradient::of_weights(layout, "head mean"),
            head_bias: Gradient::of_bias(layout, "head"),
            output: Gradient::of_narrow_weights(layout, "output"),
            output_bias: Gradient::of_bias(layout, "output"),
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

    /// Writes it as a flat vector.
    pub fn store(&self, out: &mut [f32]) {
        self.encoder.store(&self.layout, out);
        for g in [&self.own, &self.mean, &self.head_bias, &self.output, &self.output_bias] {
            g.store(&self.layout, out);
        }
    }
}
