//! Policies that need no training, to compare with.

mod centroid;
mod greedy;
mod planner;
mod simple;

pub use centroid::Centroid;
pub use greedy::Greedy;
pub use planner::{Planner, RememberingPlanner};
pub use simple::{Hover, Random};
