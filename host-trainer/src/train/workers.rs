//! Threads for the shards of a run.
//!
//! Work is split into a fixed number of shards, whatever the number of threads, and
//! each shard runs from start to end on one thread of a pool of one, so that nothing
//! below it (matrix products) splits further. Results therefore depend on the shards
//! alone.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Mutex;

/// A pool of one a thread.
pub struct Workers {
    pools: Vec<ThreadPool>,
}

impl Workers {
    /// As many threads as asked for (at least one).
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn new(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let one = |k| ThreadPoolBuilder::new().num_threads(1).thread_name(move |_| format!("shard-{k}")).build();
        Ok(Self { pools: (0..threads.max(1)).map(one).collect::<Result<_, _>>()? })
    }

    /// How many.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pools.len()
    }

    /// Runs `work(shard, item)` for every item and returns the results in order.
    ///
    /// # Panics
    /// When a shard panics.
    pub fn run<T: Send, R: Send>(&self, items: Vec<T>, work: impl Fn(usize, T) -> R + Sync) -> Vec<R> {
        let count = items.len();
        let queue = Mutex::new(items.into_iter().enumerate());
        let results: Mutex<Vec<Option<R>>> = Mutex::new((0..count).map(|_| None).collect());
        let drain = || {
            loop {
                let next = queue.lock().expect("a shard panicked").next();
                let Some((shard, item)) = next else { return };
                let result = work(shard, item);
                results.lock().expect("a shard panicked")[shard] = Some(result);
            }
        };
        spawn_all(&self.pools[..self.pools.len().min(count)], &drain);
        let results = results.into_inner().expect("a shard panicked");
        results.into_iter().map(|r| r.expect("every shard ran")).collect()
    }
}

/// Starts `work` on every pool and waits for all of them.
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
            let out = workers.run((0..9).collect(), |shard, item: usize| {
                assert_eq!(rayon::current_num_threads(), 1);
                (shard, item * item)
            });
            assert_eq!(out, (0..9).map(|k| (k, k * k)).collect::<Vec<_>>());
        }
    }
}
