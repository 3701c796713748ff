//! The threads that the shards of a run are computed on.
//!
//! Work is split into a fixed number of items (the `shards` of a run), whatever the number of
//! threads, and each item runs from start to end on one thread. Every thread is a rayon pool of
//! its own, so that nothing below it splits further. Results therefore depend on the items alone.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Mutex;

/// A fixed number of threads.
pub struct Workers {
    pools: Vec<ThreadPool>,
}

impl Workers {
    /// Starts `threads` threads, at least one.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn new(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let one = |k| ThreadPoolBuilder::new().num_threads(1).thread_name(move |_| format!("worker-{k}")).build();
        Ok(Self { pools: (0..threads.max(1)).map(one).collect::<Result<_, _>>()? })
    }

    /// Number of threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pools.len()
    }

    /// Runs `work(k, item)` for every item, k being its number, and returns the results in the
    /// order of the items.
    ///
    /// # Panics
    /// When `work` panics.
    pub fn run<T: Send, R: Send>(&self, items: Vec<T>, work: impl Fn(usize, T) -> R + Sync) -> Vec<R> {
        let count = items.len();
        let queue = Mutex::new(items.into_iter().enumerate());
        let results: Mutex<Vec<Option<R>>> = Mutex::new((0..count).map(|_| None).collect());
        let drain = || {
            loop {
                let next = queue.lock().expect("a thread panicked").next();
                let Some((k, item)) = next else { return };
                let result = work(k, item);
                results.lock().expect("a thread panicked")[k] = Some(result);
            }
        };
        spawn_all(&self.pools[..self.pools.len().min(count)], &drain);
        let results = results.into_inner().expect("a thread panicked");
        results.into_iter().map(|r| r.expect("every item ran")).collect()
    }
}

/// Runs `work` once on every pool and waits for all of them.
fn spawn_all(pools: &[ThreadPool], work: &(impl Fn() + Sync)) {
    if let Some((first, rest)) = pools.split_first() {
        first.in_place_scope(|scope| {
            scope.spawn(|_| work());
            spawn_all(rest, work);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_from_pools_of_one() {
        for threads in [1, 2, 5] {
            let workers = Workers::new(threads).unwrap();
            let out = workers.run((0..9).collect(), |k, item: usize| {
                assert_eq!(rayon::current_num_threads(), 1);
                (k, item * item)
            });
            assert_eq!(out, (0..9).map(|k| (k, k * k)).collect::<Vec<_>>());
        }
    }
}
