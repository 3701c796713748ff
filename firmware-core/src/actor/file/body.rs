//! The record inside an actor file.

use crate::actor::aggregation::Aggregation;
use crate::actor::dimensions::Dimensions;
use crate::actor::provenance::Provenance;
use crate::hash::Fnv1a;
use serde::{Deserialize, Serialize};

/// The body of the file, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body<'a> {
    /// 0 to 3 zero bytes, so that `weights` starts at a multiple of 4 in the file.
    pub align: &'a [u8],
    /// Every layer's weights in [`Dimensions::layers`] order, packed in row pairs (see
    /// [`crate::kernel`]).
    pub weights: &'a [u8],
    /// Every layer's biases and multipliers, i32 little-endian.
    pub tables: &'a [u8],
    /// Form of the observation ([`BuildObservation::ID`](crate::observation::BuildObservation::ID)).
    pub observation: u16,
    /// How neighbours' features are combined.
    pub aggregation: Aggregation,
    /// Widths.
    pub dimensions: Dimensions,
    /// Steps for which a tie-breaker holds.
    pub tie_period: u32,
    /// Multiplier of the aggregated features (0 without aggregation).
    pub aggregate_multiplier: i32,
    /// Where the actor comes from.
    pub provenance: Provenance<'a>,
    /// [`SELF_TESTS`](crate::actor::SELF_TESTS) vectors, see
    /// [`write_self_test`](crate::actor::write_self_test).
    pub self_tests: &'a [u8],
    /// [`Body::content_hash`].
    pub content_hash: u64,
}

impl Body<'_> {
    /// FNV-1a (64 bit) over what decides: observation form, aggregation, widths, tie
    /// period, aggregate multiplier, weights and tables, integers little-endian.
    #[must_use]
    pub fn content_hash(&self) -> u64 {
        let d = self.dimensions;
        let mut hash = Fnv1a::new();
        hash.write(&self.observation.to_le_bytes());
        hash.write(&[self.aggregation as u8]);
        for width in [d.observation, d.hidden, d.feature, d.head, d.actions] {
            hash.write(&width.to_le_bytes());
        }
        hash.write(&self.tie_period.to_le_bytes());
        hash.write(&self.aggregate_multiplier.to_le_bytes());
        hash.write(self.weights);
        hash.write(self.tables);
        hash.finish()
    }
}
