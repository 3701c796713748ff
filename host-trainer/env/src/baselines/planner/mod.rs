//! Planners written by hand: what a good engineer's controller makes of the same information. They are baselines for
//! trained policies, and can teach them.
//!
//! A UAV values every target within its reach by the steps of coverage that it would still win there: for each PoI that
//! it knows, the steps that remain after the flight less those that another UAV's claim already secures; and the same
//! for cells that no UAV has seen, by the PoIs expected there. It flies to the most valuable target, refined to 1 u.
//!
//! All are decentralised: a UAV knows what it sees within 13 u and what UAVs within 18 u tell it, one hop a step.

mod belief;
mod exponential;
mod fine_grid;
mod inputs;
mod kernel_table;
mod known;
mod local_map;
mod lookahead;
mod memoryless;
mod prior_map;
mod relaying;
mod remembering;
mod target_selector;
mod valuation;

pub use memoryless::Planner;
pub use relaying::RelayingPlanner;
pub use remembering::RememberingPlanner;
