//! One number that says "still the same function".

use super::file::Fnv;
use super::{Flown, FormActor, MAX_DEGREE, MAX_FEATURE, NeighbourFeature, sample};
use crate::observation::MAX_NEIGHBOURS;
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Neighbourhoods in a full signature.
pub const SIGNATURE_CASES: u32 = 10_000;

/// A signature in progress: cases are added one by one, so that a slow target can
/// report progress and feed a watchdog.
pub struct Signature {
    hash: Fnv,
    case: u32,
    /// The neighbours' features of a case, kept here because they are much for a stack.
    features: [[i8; MAX_FEATURE]; MAX_NEIGHBOURS],
}

impl Default for Signature {
    fn default() -> Self {
        Self::new()
    }
}

impl Signature {
    /// No case yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { hash: Fnv::new(), case: 0, features: [[0; MAX_FEATURE]; MAX_NEIGHBOURS] }
    }

    /// Adds the next fixed neighbourhood: a pseudo-random observation with 0 to 16
    /// neighbours (case mod 17), its feature, its logits and a sampled action.
    pub fn add_case<O: Flown>(&mut self, actor: &FormActor<'_, O>) {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(0x5160_0000_0000 | u64::from(self.case));
        let own = actor.encode(&O::draw(&mut random));
        let count = (self.case % (MAX_NEIGHBOURS as u32 + 1)) as usize;
        let mut heads = [(1u8, 0i16); MAX_NEIGHBOURS];
        for (values, head) in self.features.iter_mut().zip(&mut heads).take(count) {
            values.iter_mut().for_each(|v| *v = (random.next_u32() >> 25) as i8);
            let r = random.next_u32();
            *head = (1 + (r % u32::from(MAX_DEGREE)) as u8, (r >> 16) as i16 / 16);
        }
        let width = usize::from(actor.dimensions().feature);
        let neighbours = self.features.iter().zip(&heads).take(count).map(|(values, &(degree, attended))| {
            NeighbourFeature { values: values.get(..width).unwrap_or(&[]), degree, attended }
        });
        let logits = actor.logits(&own, count as u8 + 1, neighbours);
        own.values.iter().for_each(|v| self.hash.write(&v.to_le_bytes()));
        self.hash.write(&own.attending.to_le_bytes());
        self.hash.write(&own.attended.to_le_bytes());
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

/// The signature of an actor over its first `cases` neighbourhoods
/// ([`SIGNATURE_CASES`] by convention).
#[must_use]
pub fn signature<O: Flown>(actor: &FormActor<'_, O>, cases: u32) -> u64 {
    let mut s = Signature::new();
    (0..cases).for_each(|_| s.add_case(actor));
    s.value()
}
