//! What the machine could do at most, measured beside the trainer.

use crate::train::Workers;
use covey_net::kernel::{Vectorised, multiply_adds, vectorised};
use std::time::Instant;

/// Fused multiply-adds of all threads together, 10⁹ floating-point operations a second (two
/// each).
#[must_use]
pub fn peak_gflops(workers: &Workers) -> f64 {
    // A tenth of a second or so.
    const ROUNDS: u64 = 40_000_000;
    let start = Instant::now();
    let done = workers.run(vec![(); workers.threads()], |_, ()| multiply_adds(ROUNDS));
    2e-9 * done.iter().sum::<u64>() as f64 / start.elapsed().as_secs_f64()
}

/// Bytes that all threads together read from memory, 10⁹ a second.
#[must_use]
pub fn memory_gb_per_s(workers: &Workers) -> f64 {
    struct Sum<'a>(&'a [u64]);
    impl Vectorised for Sum<'_> {
        type Output = u64;
        #[inline(always)]
        fn call(self) -> u64 {
            self.0.iter().fold(0, |sum, v| sum.wrapping_add(*v))
        }
    }
    /// Numbers a thread: 128 MiB, more than caches hold.
    const LENGTH: usize = 16 << 20;
    let buffers: Vec<Vec<u64>> = workers.run(vec![(); workers.threads()], |_, ()| vec![1; LENGTH]);
    let start = Instant::now();
    let sums = workers.run(buffers.iter().collect(), |_, b: &Vec<u64>| vectorised(Sum(b)));
    let elapsed = start.elapsed().as_secs_f64();
    std::hint::black_box(sums);
    8e-9 * (LENGTH * buffers.len()) as f64 / elapsed
}

/// Most memory that this process had at a time, MiB; none where the system does not tell.
#[must_use]
pub fn peak_memory_mib() -> Option<f64> {
    #[cfg(unix)]
    {
        let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
        // SAFETY: a structure of zeros is a valid `rusage`, which the call fills in.
        let usage = unsafe {
            if libc::getrusage(libc::RUSAGE_SELF, usage.as_mut_ptr()) != 0 {
                return None;
            }
            usage.assume_init()
        };
        // Kilobytes, but bytes on Apple's systems.
        let unit = if cfg!(target_vendor = "apple") { 1.0 } else { 1024.0 };
        Some(usage.ru_maxrss as f64 * unit / f64::from(1 << 20))
    }
    #[cfg(not(unix))]
    None
}
