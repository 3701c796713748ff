//! The random numbers of the channel model: a stream of its own for every datagram.

use crate::random::stream;
use rand_chacha::rand_core::Rng;

/// SplitMix64 (Steele, Lea and Flood 2014): its increment, the golden ratio in 64 bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Its finaliser.
const fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The key of all streams of a channel.
pub(super) fn key(seed: u64) -> u64 {
    // The name of the stream is part of every published figure: it stays.
    stream("radio link", seed, 0).next_u64()
}

/// The random stream of one datagram. Numbers drawn early do not depend on what is drawn later, so a channel that also
/// corrupts datagrams still loses the same ones.
#[derive(Clone, Debug)]
pub(super) struct DatagramRandom(u64);

impl DatagramRandom {
    /// The stream of the `sequence`-th datagram that `from` sent to `to`.
    pub(super) const fn new(key: u64, from: u16, to: u16, sequence: u32) -> Self {
        let datagram = ((from as u64) << 48) | ((to as u64) << 32) | sequence as u64;
        Self(mixed(key ^ mixed(datagram.wrapping_add(GOLDEN))))
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
    fn every_datagram_has_a_stream_of_its_own() {
        let first = |seed, from, to, sequence| DatagramRandom::new(key(seed), from, to, sequence).next();
        let base = first(1, 2, 3, 4);
        assert_eq!(base, first(1, 2, 3, 4));
        for other in [first(2, 2, 3, 4), first(1, 3, 2, 4), first(1, 2, 4, 3), first(1, 2, 3, 5)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn probabilities_and_ranges_are_kept() {
        let mut random = DatagramRandom::new(key(5), 0, 1, 0);
        let n = 20_000;
        assert_eq!((0..n).filter(|_| random.happens(0.0)).count(), 0);
        assert_eq!((0..n).filter(|_| random.happens(1.0)).count(), n);
        let often = (0..n).filter(|_| random.happens(0.3)).count() as f64 / n as f64;
        assert!((often - 0.3).abs() < 0.01, "{often}");
        let mut seen = [0u32; 7];
        (0..n).for_each(|_| seen[random.below(7) as usize] += 1);
        assert!(seen.iter().all(|&s| s.abs_diff(n as u32 / 7) < 250), "{seen:?}");
        assert_eq!(random.below(0), 0);
    }
}
