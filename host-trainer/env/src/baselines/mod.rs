//! Policies that need no training, to compare with.

mod centroid;
mod greedy;
mod simple;

pub use centroid::Centroid;
pub use greedy::Greedy;
pub use simple::{Hover, Random};
