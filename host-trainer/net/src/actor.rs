//! The actor: encoder, aggregation, head on own feature and aggregate, 17 logits (paper,
//! equations 5 to 7; figure 4).

use crate::graph_layer::{GraphGradient, GraphLayer, GraphPass};
use crate::input::Inputs;
use crate::kernel::Init;
use crate::layers::{Bias, BlockGradient, Dense, Encoder, EncoderGradient, EncoderPass, Weights};
use crate::matrix::{Activation, Rows};
use crate::parameter_layout::ParameterLayout;
use firmware_core::actor::Aggregation;

/// An actor's parameters, laid out for the kernel's products.
#[derive(Clone, Debug)]
pub struct ActorNet {
    layout: ParameterLayout,
    encoder: Encoder,
    own: Weights,
    head_bias: Bias,
    output: Dense,
    /// The graph layer, and the head's weights on what it gives.
    graph: Option<(GraphLayer, Weights)>,
}

impl ActorNet {
    /// An actor of this layout, which must be for this aggregation; all parameters are zero until
    /// [`Self::load`].
    #[must_use]
    pub fn new(layout: &ParameterLayout, aggregation: Aggregation) -> Self {
        Self {
            encoder: Encoder::new(layout),
            own: Weights::new(layout, "head own"),
            head_bias: Bias::new(layout, "head"),
            output: Dense::new(layout, "output"),
            graph: GraphLayer::new(layout, aggregation).map(|g| (g, Weights::new(layout, "head aggregate"))),
            layout: layout.clone(),
        }
    }

    /// Takes the parameters, as many and in the order of the layout.
    pub fn load(&mut self, values: &[f32]) {
        let layout = &self.layout;
        self.encoder.load(layout, values);
        self.own.load(layout, values);
        self.head_bias.load(layout, values);
        self.output.load(layout, values);
        if let Some((graph, head)) = &mut self.graph {
            graph.load(layout, values);
            head.load(layout, values);
        }
    }
}

/// The actor's activations of a micro-batch, a row a UAV, and after the backward pass the
/// gradients by them.
#[derive(Clone, Debug)]
pub struct ActorPass {
    encoder: EncoderPass,
    graph: Option<GraphPass>,
    head: Rows,
    by_head: Rows,
    logits: Rows,
}

impl ActorPass {
    /// For actors of this layout.
    #[must_use]
    pub fn new(layout: &ParameterLayout) -> Self {
        let rows = |name| Rows::new(layout.shape(name).1);
        Self {
            encoder: EncoderPass::new(layout),
            graph: GraphPass::new(layout),
            head: rows("head own"),
            by_head: rows("head own"),
            logits: rows("output"),
        }
    }

    /// Computes the logits, in the order in which UAVs do it.
    pub fn forward(&mut self, net: &ActorNet, inputs: &Inputs) {
        self.encoder.forward(&net.encoder, inputs);
        let feature = &self.encoder.feature;
        if let (Some(pass), Some((layer, head))) = (&mut self.graph, &net.graph) {
            pass.forward(layer, inputs, feature);
            net.own.forward(feature, net.head_bias.init(), Activation::Identity, &mut self.head);
            head.forward(&pass.output, Init::Accumulate, Activation::Relu, &mut self.head);
        } else {
            net.own.forward(feature, net.head_bias.init(), Activation::Relu, &mut self.head);
        }
        net.output.forward(&self.head, Activation::Identity, &mut self.logits);
    }

    /// Adds the gradient by the parameters to `sum`, after [`Self::forward`] with the same net and
    /// inputs, when [`Self::logits_mut`] holds the gradient by the logits.
    pub fn backward(&mut self, net: &ActorNet, inputs: &Inputs, sum: &mut ActorGradient) {
        let (feature, by_feature) = (&self.encoder.feature, &mut self.encoder.by_feature);
        self.logits.fill_masks();
        sum.output.add_weights(&self.head, &self.logits);
        sum.output_bias.add_bias(&self.logits);
        net.output.backward(&self.logits, Activation::ReluGradient(&self.head), &mut self.by_head);
        sum.own.add_weights(feature, &self.by_head);
        sum.head_bias.add_bias(&self.by_head);
        if let (Some(pass), Some((layer, head)), Some((by_layer, by_aggregate))) =
            (&mut self.graph, &net.graph, &mut sum.graph)
        {
            by_aggregate.add_weights(&pass.output, &self.by_head);
            head.backward(&self.by_head, Init::Zero, Activation::ReluGradient(&pass.output), &mut pass.by_output);
            pass.backward(layer, feature, by_layer, by_feature);
            net.own.backward(&self.by_head, Init::Accumulate, Activation::ReluGradient(feature), by_feature);
        } else {
            net.own.backward(&self.by_head, Init::Zero, Activation::ReluGradient(feature), by_feature);
        }
        self.encoder.backward(&net.encoder, inputs, &mut sum.encoder);
    }

    /// Multiply-adds in products, those with a zero left out: of a forward and of a
    /// backward pass.
    #[must_use]
    pub fn multiply_adds(&self, inputs: &Inputs) -> [u64; 2] {
        let [mut forward, mut backward] = self.encoder.multiply_adds(inputs);
        let (feature, head) = (self.encoder.feature.width() as u64, self.head.width() as u64);
        let outputs = self.logits.width() as u64;
        let (rows, active) = (self.head.rows() as u64, self.head.nonzeros());
        let own = self.encoder.feature.nonzeros() * head;
        forward += own + active * outputs;
        backward += own + active * feature + 2 * rows * outputs * head;
        if let Some(g) = &self.graph {
            let [there, back] = g.multiply_adds(&self.encoder.feature);
            let products = g.output.nonzeros() * head;
            forward += there + products;
            backward += back + products + active * feature;
        }
        [forward, backward]
    }

    /// Activations of the first hidden layer, a row a UAV.
    #[must_use]
    pub const fn hidden(&self) -> &Rows {
        &self.encoder.hidden
    }

    /// Features `h`, a row a UAV: what UAVs broadcast, but for GATv2 ([`Self::ends`]).
    #[must_use]
    pub const fn feature(&self) -> &Rows {
        &self.encoder.feature
    }

    /// The combined features of each neighbourhood, a row a UAV; none without aggregation, and
    /// none with GATv2, whose [output](Self::graph) they are.
    #[must_use]
    pub fn combined(&self) -> Option<&Rows> {
        self.graph.as_ref().and_then(GraphPass::combined)
    }

    /// GATv2: `W_l h`, with which a UAV scores, and `W_r h`, which it broadcasts, a row a UAV.
    #[must_use]
    pub fn ends(&self) -> Option<&[Rows; 2]> {
        self.graph.as_ref().and_then(GraphPass::ends)
    }

    /// What the head takes beside the feature, a row a UAV; none without aggregation.
    #[must_use]
    pub fn graph(&self) -> Option<&Rows> {
        self.graph.as_ref().map(|g| &g.output)
    }

    /// Activations of the head's hidden layer, a row a UAV.
    #[must_use]
    pub const fn head(&self) -> &Rows {
        &self.head
    }

    /// Logits, a row of 17 a UAV.
    #[must_use]
    pub const fn logits(&self) -> &Rows {
        &self.logits
    }

    /// Logits, to be replaced by the gradient by them.
    pub const fn logits_mut(&mut self) -> &mut Rows {
        &mut self.logits
    }
}

/// Gradient of the loss by an actor's parameters: a sum over samples.
#[derive(Clone, Debug)]
pub struct ActorGradient {
    layout: ParameterLayout,
    encoder: EncoderGradient,
    own: BlockGradient,
    head_bias: BlockGradient,
    output: BlockGradient,
    output_bias: BlockGradient,
    graph: Option<(GraphGradient, BlockGradient)>,
}

impl ActorGradient {
    /// Zero, for actors of this layout.
    #[must_use]
    pub fn new(layout: &ParameterLayout) -> Self {
        Self {
            encoder: EncoderGradient::new(layout),
            own: BlockGradient::of_weights(layout, "head own"),
            head_bias: BlockGradient::of_bias(layout, "head"),
            output: BlockGradient::of_narrow_weights(layout, "output"),
            output_bias: BlockGradient::of_bias(layout, "output"),
            graph: GraphGradient::new(layout).map(|g| (g, BlockGradient::of_weights(layout, "head aggregate"))),
            layout: layout.clone(),
        }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.encoder.clear();
        for g in [&mut self.own, &mut self.head_bias, &mut self.output, &mut self.output_bias] {
            g.clear();
        }
        if let Some((graph, head)) = &mut self.graph {
            graph.clear();
            head.clear();
        }
    }

    /// Writes it to a flat vector of the layout; `values` are the parameters that it was computed
    /// at.
    pub fn store(&self, values: &[f32], out: &mut [f32]) {
        self.encoder.store(&self.layout, out);
        for g in [&self.own, &self.head_bias, &self.output, &self.output_bias] {
            g.store(&self.layout, out);
        }
        if let Some((graph, head)) = &self.graph {
            graph.store(&self.layout, values, out);
            head.store(&self.layout, out);
        }
    }
}
