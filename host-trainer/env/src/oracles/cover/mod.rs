//! The maximum cover: the most PoIs that so many discs can cover, with a proof.
//!
//! 1. `candidates`: discs around a PoI and through two PoIs give candidate sets of PoIs; the maximal ones are kept.
//! 2. `local_search`: greedy selection, improved by exchange, gives the first incumbent; perturbation improves it.
//! 3. `lagrangian_bound`: prices on the PoIs give an upper bound.
//! 4. `branch_and_bound`: a search closes what gap is left.

mod bit_matrix;
mod branch_and_bound;
mod candidates;
mod disc;
mod lagrangian_bound;
mod local_search;
mod maximum_cover;
mod subproblem;
#[cfg(test)]
mod tests;

pub use maximum_cover::{Cover, NODE_LIMIT, best_sites, maximum_cover, maximum_cover_within};
