//! Policies that need no training, to compare with.

mod centroid;
mod follower;
mod greedy;
mod planner;
mod simple;

pub use centroid::Centroid;
pub use follower::{Follower, advice};
pub use greedy::Greedy;
pub use planner::{Planner, RememberingPlanner};
pub use simple::{Hover, Random};
