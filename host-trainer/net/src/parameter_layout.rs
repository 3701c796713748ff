//! Where weights and biases lie in a network's flat parameter vector.

use firmware_core::action::ACTIONS;
use firmware_core::actor::{Aggregation, Dimensions};

/// One weight matrix (`inputs × outputs`, row-major) or bias (`1 × outputs`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterBlock {
    /// Name, unique in its layout.
    pub name: &'static str,
    /// Rows: inputs, or 1 for a bias.
    pub inputs: usize,
    /// Columns: outputs.
    pub outputs: usize,
    /// Gain of the orthogonal initialisation; 0 starts at zero.
    pub gain: f32,
    /// Index of its first number in the flat vector.
    pub start: usize,
}

impl ParameterBlock {
    /// How many numbers it has.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.inputs * self.outputs
    }

    /// Whether it has no numbers.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The blocks of a network's flat parameter vector, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterLayout {
    blocks: Vec<ParameterBlock>,
}

/// Gain before a ReLU.
const RELU_GAIN: f32 = std::f32::consts::SQRT_2;

impl ParameterLayout {
    fn new(parts: &[(&'static str, usize, usize, f32)]) -> Self {
        let mut start = 0;
        let blocks = parts
            .iter()
            .map(|&(name, inputs, outputs, gain)| {
                let block = ParameterBlock { name, inputs, outputs, gain, start };
                start += block.len();
                block
            })
            .collect();
        Self { blocks }
    }

    /// The actor: encoder of two layers, aggregation, head on own feature and
    /// aggregate, 17 logits. The graph layer is `W` of equations (5) to (7); GATv2 has two of
    /// them, for the receiver and the sender of a feature.
    #[must_use]
    pub fn actor(d: Dimensions, aggregation: Aggregation) -> Self {
        let [o, e, h, m] = [d.observation, d.hidden, d.feature, d.head].map(usize::from);
        let mut parts = vec![
            ("encoder1", o, e, RELU_GAIN),
            ("encoder1 bias", 1, e, 0.0),
            ("encoder2", e, h, RELU_GAIN),
            ("encoder2 bias", 1, h, 0.0),
            ("head own", h, m, RELU_GAIN),
            ("head bias", 1, m, 0.0),
            ("output", m, ACTIONS, 0.01),
            ("output bias", 1, ACTIONS, 0.0),
        ];
        match aggregation {
            Aggregation::None => {}
            Aggregation::Gcn | Aggregation::Gat | Aggregation::Sage => {
                parts.extend([("graph", h, h, RELU_GAIN), ("graph bias", 1, h, 0.0)]);
            }
            Aggregation::GatV2 => parts.extend([
                ("receiver", h, h, RELU_GAIN),
                ("receiver bias", 1, h, 0.0),
                ("sender", h, h, RELU_GAIN),
                ("sender bias", 1, h, 0.0),
                ("attention", h, 1, 1.0),
            ]),
        }
        if aggregation != Aggregation::None {
            parts.push(("head aggregate", h, m, RELU_GAIN));
        }
        if aggregation == Aggregation::Gat {
            parts.extend([("attention receiver", h, 1, 1.0), ("attention sender", h, 1, 1.0)]);
        }
        Self::new(&parts)
    }

    /// The central critic: the observations of all UAVs, each embedded as in the actor,
    /// own embedding beside the mean over all (so it takes any number of UAVs in any
    /// order); one value a UAV.
    #[must_use]
    pub fn critic(d: Dimensions) -> Self {
        let [o, e, h, m] = [d.observation, d.hidden, d.feature, d.head].map(usize::from);
        Self::new(&[
            ("encoder1", o, e, RELU_GAIN),
            ("encoder1 bias", 1, e, 0.0),
            ("encoder2", e, h, RELU_GAIN),
            ("encoder2 bias", 1, h, 0.0),
            ("head own", h, m, RELU_GAIN),
            ("head mean", h, m, RELU_GAIN),
            ("head bias", 1, m, 0.0),
            ("output", m, 1, 1.0),
            ("output bias", 1, 1, 0.0),
        ])
    }

    /// The blocks in order.
    #[must_use]
    pub fn blocks(&self) -> &[ParameterBlock] {
        &self.blocks
    }

    /// Length of the flat vector.
    #[must_use]
    pub fn len(&self) -> usize {
        self.blocks.iter().map(ParameterBlock::len).sum()
    }

    /// Whether the network has no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// The numbers of the block of this name (empty if there is none).
    #[must_use]
    pub fn block<'v>(&self, values: &'v [f32], name: &str) -> &'v [f32] {
        self.blocks.iter().find(|p| p.name == name).map_or(&[], |p| &values[p.start..p.start + p.len()])
    }

    /// Whether there is a block of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.blocks.iter().any(|p| p.name == name)
    }

    /// Rows and columns of the block of this name.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn shape(&self, name: &str) -> (usize, usize) {
        let block = self.find(name);
        (block.inputs, block.outputs)
    }

    /// The numbers of the block of this name.
    ///
    /// # Panics
    /// When there is none.
    pub fn block_mut<'v>(&self, values: &'v mut [f32], name: &str) -> &'v mut [f32] {
        let block = self.find(name);
        &mut values[block.start..block.start + block.len()]
    }

    fn find(&self, name: &str) -> &ParameterBlock {
        self.blocks.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no block {name}"))
    }
}
