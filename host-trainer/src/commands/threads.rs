//! Threads of the machine and of evaluations.

/// Threads that the machine runs at the same time.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Sets the threads that evaluations use; none: one a core. A second call changes nothing.
pub fn use_threads(threads: Option<usize>) {
    // Fails only when the pool is there already, which is as good.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build_global();
}
