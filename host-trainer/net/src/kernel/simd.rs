//! Choosing code for the processor when the program runs.

use super::lanes::LANES;

/// Work on plain slices that the compiler vectorises: it is compiled twice, once for AVX2 with
/// FMA.
pub trait Vectorised {
    /// What the work returns.
    type Output;

    /// Does the work. Must be `#[inline(always)]`, and so must what it calls, or it is compiled
    /// for the oldest processor only.
    fn call(self) -> Self::Output;
}

/// Does the work with the instructions that this processor has.
pub fn vectorised<V: Vectorised>(work: V) -> V::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn with_avx2<V: Vectorised>(work: V) -> V::Output {
            work.call()
        }
        if has_avx2() {
            // SAFETY: the processor has what `with_avx2` is compiled for.
            return unsafe { with_avx2(work) };
        }
    }
    work.call()
}

/// Whether this processor has AVX2, FMA and what comes with them.
#[must_use]
pub fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Multiply-adds that depend on nothing in memory, as many at a time as keep a core's
/// units busy: the peak that products are measured against. Returns how many it did.
#[must_use]
pub fn multiply_adds(rounds: u64) -> u64 {
    struct Chains(u64);
    impl Vectorised for Chains {
        type Output = u64;
        #[inline(always)]
        fn call(self) -> u64 {
            const CHAINS: usize = 12;
            let (factor, term) = (std::hint::black_box(0.5f32), std::hint::black_box(1.0f32));
            let mut sums = [[0.0f32; LANES]; CHAINS];
            for _ in 0..self.0 {
                for chain in &mut sums {
                    for s in chain {
                        *s = s.mul_add(factor, term);
                    }
                }
            }
            std::hint::black_box(sums);
            self.0 * (CHAINS * LANES) as u64
        }
    }
    vectorised(Chains(rounds))
}
