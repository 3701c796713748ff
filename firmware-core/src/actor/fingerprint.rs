//! One number that says "still the same function".

use super::feature::{MAX_DEGREE, MAX_FEATURE, NeighbourFeature};
use super::input_layer::ActorInput;
use super::quantised::QuantisedActor;
use super::softmax::sample;
use crate::hash::Fnv1a;
use crate::observation::MAX_NEIGHBOURS;
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Neighbourhoods in a full fingerprint.
pub const FINGERPRINT_CASES: u32 = 10_000;

/// A fingerprint in progress: cases are added one by one, so that a slow target can
/// report progress and feed a watchdog.
pub struct Fingerprint {
    hash: Fnv1a,
    case: u32,
    /// The neighbours' features of a case, kept here because they are much for a stack.
    features: [[i8; MAX_FEATURE]; MAX_NEIGHBOURS],
}

impl Default for Fingerprint {
    fn default() -> Self {
        Self::new()
    }
}

impl Fingerprint {
    /// No case yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { hash: Fnv1a::new(), case: 0, features: [[0; MAX_FEATURE]; MAX_NEIGHBOURS] }
    }

    /// Adds the next fixed neighbourhood: a pseudo-random observation with 0 to 16
    /// neighbours (case mod 17), its feature, its logits and a sampled action.
    pub fn add_case<O: ActorInput>(&mut self, actor: &QuantisedActor<'_, O>) {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(0x5160_0000_0000 | u64::from(self.case));
        let own = actor.encode(&O::random(&mut random));
        let count = (self.case % (MAX_NEIGHBOURS as u32 + 1)) as usize;
        let mut heads = [(1u8, 0i16); MAX_NEIGHBOURS];
        for (values, head) in self.features.iter_mut().zip(&mut heads).take(count) {
            values.iter_mut().for_each(|v| *v = (random.next_u32() >> 25) as i8);
            let r = random.next_u32();
            *head = (1 + (r % u32::from(MAX_DEGREE)) as u8, (r >> 16) as i16 / 16);
        }
        let width = usize::from(actor.dimensions().feature);
        let neighbours = self.features.iter().zip(&heads).take(count).map(|(values, &(degree, attention_source))| {
            NeighbourFeature { values: values.get(..width).unwrap_or(&[]), degree, attention_source }
        });
        let logits = actor.logits(&own, count as u8 + 1, neighbours);
        own.values.iter().for_each(|v| self.hash.write(&v.to_le_bytes()));
        self.hash.write(&own.attention_destination.to_le_bytes());
        self.hash.write(&own.attention_source.to_le_bytes());
        logits.iter().for_each(|l| self.hash.write(&l.to_le_bytes()));
        self.hash.write(&[sample(&logits, random.next_u32()).index()]);
        self.case += 1;
    }

    /// The number so far.
    #[must_use]
    pub const fn value(&self) -> u64 {
        self.hash.finish()
    }
}

/// The fingerprint of an actor over its first `cases` neighbourhoods
/// ([`FINGERPRINT_CASES`] by convention).
#[must_use]
pub fn fingerprint<O: ActorInput>(actor: &QuantisedActor<'_, O>, cases: u32) -> u64 {
    let mut s = Fingerprint::new();
    (0..cases).for_each(|_| s.add_case(actor));
    s.value()
}
