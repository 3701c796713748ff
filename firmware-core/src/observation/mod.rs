//! What a UAV knows when it decides, as [`LEN`] numbers of one byte.
//!
//! | index | what | value |
//! |---|---|---|
//! | 0, 1 | own position, x and y | (p − side/2)/(side/2) |
//! | 2, 3 | own velocity | v / 4 u/step |
//! | 4 | own tie-breaker of the step | t / 127 |
//! | 5 | neighbours in range | n / 16 |
//! | 6 | available PoIs in view: those that no neighbour with priority covers | n / 48 |
//! | 7, 8 | mean offset of the available PoIs in view | Δ / 13 u |
//! | 9, 10 | separation, away from the neighbours: −Σ Δ·(1 − d²/18²) | / 18 u |
//! | 11 | value of the place where the UAV is | PoI-steps / 192 |
//! | 12 + k | value of the eight places around it, 4 u away on either axis | PoI-steps / 192 |
//! | 20 + k | the same 8 u away | PoI-steps / 192 |
//! | 28 | value of the target, the best place, with unseen PoIs and the bonus for lying ahead | PoI-steps / 192 |
//! | 29, 30 | its offset | Δ / 18 u |
//! | 31, 32 | its offset, refined | Δ / 18 u |
//! | 33, 34 | change of velocity that flies to it | / 8 u/step |
//! | 35 | PoIs covered there | n / 22 |
//! | 36 + 6 k | k-th nearest neighbour: present | 1 |
//! | … + 1, 2 | its offset | Δ / 18 u |
//! | … + 3, 4 | its velocity | v / 4 u/step |
//! | … + 5 | priority: +1 when this UAV has it, −1 when the neighbour does | ±1 |
//! | 72 + 4 k | k-th nearest PoI in view: present | 1 |
//! | … + 1, 2 | its offset | Δ / 13 u |
//! | … + 3 | covered by a neighbour with priority, or only by ones that yield | 1 or ½ |
//!
//! Each number is stored as `round(127 · value)` clamped to ±127; absent
//! neighbours and PoIs are zeros. Directions are those of the action table. This form has the id
//! [`ID`], which the actor file repeats: an actor never meets an observation it was not trained
//! on. Of two UAVs the one with the higher tie-breaker has priority; the other yields.
//! `docs/observation.md` has every detail.

mod candidates;
pub mod cells;
mod compact;
mod exploration;
mod form;
mod layout;
mod nearest;
mod neighbours;
mod poi;
mod scale;
mod scene;
mod separation;
mod target;
#[cfg(test)]
mod tests;

pub use compact::observe;
pub use form::BuildObservation;
pub use layout::{ID, LEN, Observation, TARGET_VELOCITY_CHANGE};
pub use neighbours::{MAX_NEIGHBOURS, Neighbour, Neighbours};
pub use scene::{HALF_SIDE_LIMIT, Scene};
