//! Policies that need no training, to compare trained ones with: random, hovering, greedy, heuristics and planners.

mod centroid;
mod follower;
mod greedy;
mod planner;
mod simple;

pub use centroid::Centroid;
pub use follower::{Follower, recommended_action};
pub use greedy::Greedy;
pub use planner::{Planner, RelayingPlanner, RememberingPlanner};
pub use simple::{Hover, Random};
