//! The quantised actor.
//!
//! Network (paper, sections 2.2 and 3.2; all activations int8):
//!
//! ```text
//! observation (160) → encoder 1 → ReLU → encoder 2 → ReLU → h (64)       encode: once a step
//! neighbours' h, own h → aggregate → graph layer → ReLU → y (64)          none | GCN | GAT
//! [h ‖ y] → head → ReLU → output → 17 logits                              decide
//! ```
//!
//! `h` is what a UAV broadcasts. For GAT the score of equation (6) splits into a term
//! of the receiver and one of the sender, so a sender adds one number, its half.
//! Everything is read in place from the actor file; the actor itself is a few
//! slices.

mod aggregate;
pub mod file;
mod fingerprint;
mod input_layer;
pub mod layer;
mod self_test;
pub mod softmax;

pub use aggregate::MAX_DEGREE;
pub use file::{LoadError, Provenance};
pub use fingerprint::{FINGERPRINT_CASES, Fingerprint, fingerprint};
pub use input_layer::{ActorInput, SparseLayer};
pub use self_test::{SELF_TESTS, SelfTest, SelfTestError, write_self_test};
pub use softmax::{Logits, Mode, argmax, sample};

use crate::action::{ACTIONS, Action};
use crate::kernel::requantise;
use crate::observation::cells::Cells;
use crate::observation::{MAX_NEIGHBOURS, Observation};
use crate::random::{action_draw, tie_breaker};
use heapless::Vec;
use layer::{Activations, Layer, MAX_COLUMNS, MAX_ROWS};

/// Greatest width of a feature.
pub const MAX_FEATURE: usize = 64;

/// How neighbours' features are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Aggregation {
    /// Not at all: plain PPO.
    None,
    /// Graph convolution, equation (5).
    Gcn,
    /// Graph attention, equations (6) and (7).
    Gat,
}

impl Aggregation {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::None, Self::Gcn, Self::Gat];

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Gcn => "gcn",
            Self::Gat => "gat",
        }
    }
}

/// Widths of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Dimensions {
    /// Numbers in an observation.
    pub observation: u16,
    /// First hidden layer, at most 128.
    pub hidden: u16,
    /// Feature `h`, even, at most 64.
    pub feature: u16,
    /// Hidden layer of the head, at most 128.
    pub head: u16,
    /// Actions.
    pub actions: u16,
}

impl Dimensions {
    /// Rows and columns of every layer in file order: encoder 1, encoder 2, attention
    /// (GAT only), graph (GCN and GAT), head, output.
    pub fn layers(self, aggregation: Aggregation) -> impl Iterator<Item = (usize, usize)> {
        let [o, e, h, m, a] = [self.observation, self.hidden, self.feature, self.head, self.actions].map(usize::from);
        let (attention, graph, joined) = match aggregation {
            Aggregation::None => (None, None, h),
            Aggregation::Gcn => (None, Some((h, h)), 2 * h),
            Aggregation::Gat => (Some((2, h)), Some((h, h)), 2 * h),
        };
        [Some((e, o)), Some((h, e)), attention, graph, Some((m, joined)), Some((a, m))].into_iter().flatten()
    }
}

/// What a UAV computes from its own observation and, but for [`Self::attention_destination`],
/// broadcasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Feature {
    /// `h`, of which the actor's feature width is used; the rest is zero.
    pub values: [i8; MAX_FEATURE],
    /// GAT: the receiver's half of the score, kept at home (0 otherwise).
    pub attention_destination: i16,
    /// GAT: the sender's half of the score, broadcast (0 otherwise).
    pub attention_source: i16,
}

/// A neighbour's feature as it was received.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourFeature<'f> {
    /// `h`.
    pub values: &'f [i8],
    /// The sender's degree, itself included, 1 to [`MAX_DEGREE`].
    pub degree: u8,
    /// The sender's half of the GAT score.
    pub attention_source: i16,
}

/// An actor that observes in the compact form.
pub type Actor<'a> = QuantisedActor<'a, Observation>;

/// An actor that observes cells, as the paper's UAVs do.
pub type CellsActor<'a> = QuantisedActor<'a, Cells>;

/// A loaded actor. It borrows the file, which must have been found sound. A program holds the
/// code of those forms only that it uses.
#[derive(Clone, Copy, Debug)]
pub struct QuantisedActor<'a, O: ActorInput> {
    aggregation: Aggregation,
    dimensions: Dimensions,
    tie_period: u32,
    content_hash: u64,
    provenance: Provenance<'a>,
    self_tests: &'a [u8],
    encoder1: O::First<'a>,
    encoder2: Layer<'a>,
    attention: Layer<'a>,
    graph: Layer<'a>,
    head: Layer<'a>,
    output: Layer<'a>,
    aggregate_multiplier: i32,
}

impl<'a, O: ActorInput> QuantisedActor<'a, O> {
    /// How it aggregates.
    #[must_use]
    pub const fn aggregation(&self) -> Aggregation {
        self.aggregation
    }

    /// Its widths.
    #[must_use]
    pub const fn dimensions(&self) -> Dimensions {
        self.dimensions
    }

    /// Where it comes from.
    #[must_use]
    pub const fn provenance(&self) -> Provenance<'a> {
        self.provenance
    }

    /// Steps for which a tie-breaker holds.
    #[must_use]
    pub const fn tie_period(&self) -> u32 {
        self.tie_period
    }

    /// Hash of all that decides: shapes, weights, multipliers.
    #[must_use]
    pub const fn content_hash(&self) -> u64 {
        self.content_hash
    }

    /// What feature messages carry of the content hash: its lower half XOR its upper half.
    #[must_use]
    pub const fn message_hash(&self) -> u32 {
        (self.content_hash ^ (self.content_hash >> 32)) as u32
    }

    /// The tie-breaker that UAV `id` announces for `step`.
    #[must_use]
    pub fn tie_breaker(&self, seed: u64, id: u16, step: u32) -> i8 {
        tie_breaker(seed, id, step, self.tie_period)
    }

    /// Encodes an observation.
    #[must_use]
    pub fn encode(&self, observation: &O) -> Feature {
        let mut y = Activations::<MAX_ROWS>::zero();
        observation.apply(&self.encoder1, &mut y.0);
        let mut h = Activations::<MAX_FEATURE>::zero();
        self.encoder2.apply(&y.0, &mut h.0);
        let mut halves = [0i16; 2];
        if self.aggregation == Aggregation::Gat {
            self.attention.apply_wide(&h.0, &mut halves);
        }
        let [attention_destination, attention_source] = halves;
        let mut values = [0i8; MAX_FEATURE];
        for (v, &h) in values.iter_mut().zip(&h.0) {
            *v = h as i8; // 0..=127
        }
        Feature { values, attention_destination, attention_source }
    }

    /// The logits of a UAV with this feature and degree (itself included) whose
    /// neighbours sent these features. At most the first 16 count.
    #[must_use]
    pub fn logits<'f>(
        &self,
        own: &Feature,
        degree: u8,
        neighbours: impl IntoIterator<Item = NeighbourFeature<'f>>,
    ) -> Logits {
        let mut first: Vec<_, MAX_NEIGHBOURS> = Vec::new();
        for n in neighbours {
            if first.push(n).is_err() {
                break;
            }
        }
        self.logits_among(own, degree, &first)
    }

    /// [`Self::logits`] once in the program, whatever iterators feed it. Its parts are functions
    /// of their own, so that a board's stack has room for the deeper one, not for both.
    #[inline(never)]
    fn logits_among(&self, own: &Feature, degree: u8, neighbours: &[NeighbourFeature<'_>]) -> Logits {
        let mut joined = Activations::<{ 2 * MAX_FEATURE }>::zero();
        for (x, &h) in joined.0.iter_mut().zip(&own.values) {
            *x = i16::from(h);
        }
        if let Some(y) = joined.0.get_mut(usize::from(self.dimensions.feature)..) {
            self.gather(own, degree, neighbours, y);
        }
        self.judge(&joined.0)
    }

    /// The head's two layers.
    #[inline(never)]
    fn judge(&self, joined: &[i16]) -> Logits {
        let mut hidden = Activations::<MAX_ROWS>::zero();
        self.head.apply(joined, &mut hidden.0);
        let mut logits = [0i16; ACTIONS];
        self.output.apply_wide(&hidden.0, &mut logits);
        logits
    }

    /// Aggregates, and applies the graph layer; `y` stays as it is without aggregation.
    #[inline(never)]
    fn gather(&self, own: &Feature, degree: u8, neighbours: &[NeighbourFeature<'_>], y: &mut [i16]) {
        let neighbours = neighbours.iter().copied();
        let sums = match self.aggregation {
            Aggregation::None => return,
            Aggregation::Gcn => aggregate::gcn(own, degree, neighbours),
            Aggregation::Gat => aggregate::gat(own, neighbours),
        };
        let mut mean = Activations::<MAX_FEATURE>::zero();
        for (x, &sum) in mean.0.iter_mut().zip(&sums) {
            *x = requantise(sum, self.aggregate_multiplier).clamp(-127, 127) as i16;
        }
        self.graph.apply(&mean.0, y);
    }

    /// The action of these logits for UAV `id` at `step`.
    #[must_use]
    pub fn choose(&self, logits: &Logits, mode: Mode, seed: u64, id: u16, step: u32) -> Action {
        match mode {
            Mode::Argmax => argmax(logits),
            Mode::Sample => sample(logits, action_draw(seed, id, step)),
        }
    }
}

const _: () = assert!(2 * MAX_FEATURE <= MAX_COLUMNS && MAX_FEATURE <= MAX_ROWS);
