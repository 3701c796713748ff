//! What a UAV has heard of its neighbours.
//!
//! The table keeps the last beacon and the last feature of up to
//! [`MAX_NEIGHBOURS`](crate::observation::MAX_NEIGHBOURS) UAVs. A late beacon is extrapolated by its velocity and a late feature used as it is,
//! both until they are [`MAX_AGE_STEPS`] old. When the table is full the nearest stay.
//! Training uses the same table, so a dense swarm and a bad radio bring no surprise.
//!
//! All times are of the swarm's common clock. Clocks, steps and sequence numbers wrap
//! around; of two of them the newer is the one that is less than half a turn ahead. A
//! beacon or feature that lies in the future by more than [`MAX_AHEAD_STEPS`] is not
//! taken and one that is kept is forgotten: so a clock that jumps back leaves no neighbours
//! that are long gone.

mod age;
mod entry;
mod moment;
mod outcome;
mod table;

pub use age::{MAX_AGE_STEPS, MAX_AHEAD_STEPS};
pub use entry::{BELIEVED_SPEED_U, POSITION_NOISE_U};
pub use moment::Moment;
pub use outcome::MessageOutcome;
pub use table::{DEFAULT_STEP_MS, NeighbourTable, STEP_MS_LIMIT};
