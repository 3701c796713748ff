//! Random numbers of the host: one named stream for each seed, index and purpose.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A ChaCha8 stream. Streams differ when `purpose`, `seed` or `index` differ, and
/// none depends on another, so worlds can be made in any order and on any thread.
/// Only the first 24 bytes of `purpose` count.
///
/// The numbers drawn by [`unit()`], [`below`] and [`normal_pair`] are fixed by this module
/// and by ChaCha alone: the same on every target and with every version of `rand`.
#[must_use]
pub fn stream(purpose: &str, seed: u64, index: u64) -> ChaCha8Rng {
    let mut key = [0u8; 32];
    let (head, tail) = key.split_at_mut(8);
    head.copy_from_slice(&seed.to_le_bytes());
    for (k, b) in tail.iter_mut().zip(purpose.bytes()) {
        *k = b;
    }
    let mut rng = ChaCha8Rng::from_seed(key);
    rng.set_stream(index);
    rng
}

/// Uniform in [0, 1), 53 bits.
pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Uniform in [low, high).
pub fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * unit(rng)
}

/// Uniform in 0..`n` (multiply-shift; for small `n` its bias is below 2⁻³²·n). 0 when
/// `n` is 0.
pub fn below(rng: &mut ChaCha8Rng, n: u32) -> u32 {
    ((u64::from(rng.next_u32()) * u64::from(n)) >> 32) as u32
}

/// Two independent standard normal numbers (Box and Muller), computed in software so
/// that no target's own logarithm or cosine shows.
pub fn normal_pair(rng: &mut ChaCha8Rng) -> (f64, f64) {
    // 1 − u lies in (0, 1], so the logarithm is finite.
    let r = libm::sqrt(-2.0 * libm::log(1.0 - unit(rng)));
    let angle = core::f64::consts::TAU * unit(rng);
    (r * libm::cos(angle), r * libm::sin(angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_named() {
        let first = |p: &str, s, i| stream(p, s, i).next_u64();
        let base = first("a", 1, 1);
        assert_eq!(base, first("a", 1, 1));
        for other in [first("b", 1, 1), first("a", 2, 1), first("a", 1, 2)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut rng = stream("test", 3, 0);
        let n = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..n / 2 {
            let (a, b) = normal_pair(&mut rng);
            sum += a + b;
            squares += a * a + b * b;
        }
        let n = f64::from(n);
        assert!((sum / n).abs() < 0.03, "{}", sum / n);
        assert!((squares / n - 1.0).abs() < 0.04, "{}", squares / n);
    }

    #[test]
    fn below_stays_below() {
        let mut rng = stream("test", 4, 0);
        let mut seen = [false; 17];
        for _ in 0..2_000 {
            seen[below(&mut rng, 17) as usize] = true;
        }
        assert!(seen.iter().all(|&s| s));
        assert_eq!(below(&mut rng, 0), 0);
    }
}
