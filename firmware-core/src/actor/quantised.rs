//! The loaded actor, and from an observation to an action.

use super::aggregation::Aggregation;
use super::aggregator::Aggregator;
use super::dimensions::Dimensions;
use super::feature::{Feature, MAX_FEATURE, NeighbourFeature};
use super::input_layer::ActorInput;
use super::layer::{Activations, Layer, MAX_INPUTS, MAX_ROWS};
use super::policy_id::PolicyId;
use super::provenance::Provenance;
use super::softmax::{Logits, Mode, argmax, sample};
use crate::action::{ACTIONS, Action};
use crate::observation::cells::Cells;
use crate::observation::{MAX_NEIGHBOURS, Observation};
use crate::random::{action_draw, tie_breaker};
use heapless::Vec;

/// An actor that observes in the compact form.
pub type Actor<'a> = QuantisedActor<'a, Observation>;

/// An actor that observes cells, as the paper's UAVs do.
pub type CellsActor<'a> = QuantisedActor<'a, Cells>;

/// A loaded actor. It borrows the file, which must have been found sound. A program holds the
/// code of those forms only that it uses.
#[derive(Clone, Copy, Debug)]
pub struct QuantisedActor<'a, O: ActorInput> {
    pub(super) dimensions: Dimensions,
    pub(super) tie_period: u32,
    pub(super) content_hash: u64,
    pub(super) provenance: Provenance<'a>,
    pub(super) self_tests: &'a [u8],
    pub(super) encoder1: O::InputLayer<'a>,
    pub(super) encoder2: Layer<'a>,
    pub(super) aggregator: Aggregator<'a>,
    pub(super) head: Layer<'a>,
    pub(super) output: Layer<'a>,
    pub(super) aggregate_multiplier: i32,
}

impl<'a, O: ActorInput> QuantisedActor<'a, O> {
    /// How it aggregates.
    #[must_use]
    pub const fn aggregation(&self) -> Aggregation {
        self.aggregator.kind()
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

    /// What its swarm needs to know of the policy.
    #[must_use]
    pub const fn policy_id(&self) -> PolicyId {
        let width = match self.aggregator {
            Aggregator::None => 0,
            // Loading bounds it by 64.
            _ => self.dimensions.feature as u8,
        };
        PolicyId { hash: self.message_hash(), width }
    }

    /// The tie-breaker that UAV `id` announces for `step`.
    #[must_use]
    pub fn tie_breaker(&self, seed: u64, id: u16, step: u32) -> i8 {
        tie_breaker(seed, id, step, self.tie_period)
    }

    /// Encodes an observation.
    #[must_use]
    pub fn encode(&self, observation: &O) -> Feature {
        let mut h = Activations::<MAX_FEATURE>::zero();
        self.encoder(observation, &mut h);
        self.aggregator.feature(&h)
    }

    /// The encoder's two layers.
    #[inline(never)]
    fn encoder(&self, observation: &O, h: &mut Activations<MAX_FEATURE>) {
        let mut y = Activations::<MAX_ROWS>::zero();
        observation.apply(&self.encoder1, &mut y.0);
        self.encoder2.apply(&y.0, &mut h.0);
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
        for (x, &h) in joined.0.iter_mut().zip(&own.own) {
            *x = i16::from(h);
        }
        if let Some(y) = joined.0.get_mut(usize::from(self.dimensions.feature)..) {
            self.aggregate(own, degree, neighbours, y);
        }
        self.head(&joined.0)
    }

    /// The head's two layers.
    #[inline(never)]
    fn head(&self, joined: &[i16]) -> Logits {
        let mut hidden = Activations::<MAX_ROWS>::zero();
        self.head.apply(joined, &mut hidden.0);
        let mut logits = [0i16; ACTIONS];
        self.output.apply_wide(&hidden.0, &mut logits);
        logits
    }

    /// Aggregates; `y` stays as it is without aggregation.
    #[inline(never)]
    fn aggregate(&self, own: &Feature, degree: u8, neighbours: &[NeighbourFeature<'_>], y: &mut [i16]) {
        self.aggregator.apply(own, degree, neighbours, self.aggregate_multiplier, y);
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

const _: () = assert!(2 * MAX_FEATURE <= MAX_INPUTS && MAX_FEATURE <= MAX_ROWS);
