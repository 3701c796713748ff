//! Oracles, which know every PoI from the start: upper bounds to compare policies with.

mod assignment;
pub mod cover;
mod fly_to_sites;
mod parked;
mod targets;

pub use fly_to_sites::FlyToSites;
pub use parked::{evaluate_parked, spawn_parked};
