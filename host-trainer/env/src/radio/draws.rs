//! Random numbers of single datagrams.

use crate::random::stream;
use rand_chacha::rand_core::Rng;

/// Steele, Lea and Flood's SplitMix64: the golden ratio in 64 bits, and the finalizer.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

const fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The key of all draws of a link.
pub(super) fn key(seed: u64) -> u64 {
    stream("radio link", seed, 0).next_u64()
}

/// The numbers of one datagram. What is drawn first does not depend on what is drawn later,
/// so a link that also damages datagrams still loses the same ones.
#[derive(Clone, Debug)]
pub(super) struct Draws(u64);

impl Draws {
    /// Those of the `sequence`-th datagram that `from` sent to `to`.
    pub(super) const fn new(key: u64, from: u16, to: u16, sequence: u32) -> Self {
        let place = ((from as u64) << 48) | ((to as u64) << 32) | sequence as u64;
        Self(mixed(key ^ mixed(place.wrapping_add(GOLDEN))))
    }

    const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mixed(self.0)
    }

    /// True with this probability: never at 0, always at 1.
    pub(super) fn happens(&mut self, probability: f64) -> bool {
        const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
        ((self.next() >> 11) as f64 * UNIT) < probability
    }

    /// Uniform in 0..`n` (multiply-shift; its bias is below 2⁻³²·n). 0 when `n` is 0.
    pub(super) const fn below(&mut self, n: u32) -> u32 {
        (((self.next() >> 32) * n as u64) >> 32) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_has_numbers_of_its_own() {
        let first = |seed, from, to, sequence| Draws::new(key(seed), from, to, sequence).next();
        let base = first(1, 2, 3, 4);
        assert_eq!(base, first(1, 2, 3, 4));
        for other in [first(2, 2, 3, 4), first(1, 3, 2, 4), first(1, 2, 4, 3), first(1, 2, 3, 5)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn probabilities_and_ranges_are_kept() {
        let mut draws = Draws::new(key(5), 0, 1, 0);
        let n = 20_000;
        assert_eq!((0..n).filter(|_| draws.happens(0.0)).count(), 0);
        assert_eq!((0..n).filter(|_| draws.happens(1.0)).count(), n);
        let often = (0..n).filter(|_| draws.happens(0.3)).count() as f64 / n as f64;
        assert!((often - 0.3).abs() < 0.01, "{often}");
        let mut seen = [0u32; 7];
        (0..n).for_each(|_| seen[draws.below(7) as usize] += 1);
        assert!(seen.iter().all(|&s| s.abs_diff(n as u32 / 7) < 250), "{seen:?}");
        assert_eq!(draws.below(0), 0);
    }
}
