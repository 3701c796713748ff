//! When what happens within a step.

use firmware_core::neighbour_table::DEFAULT_STEP_MS;

/// When a UAV observes, encodes and broadcasts its feature, ms after the beginning of the step, when its beacon went
/// out.
pub const ENCODE_MS: u64 = 400;
/// When a UAV decides on its action, ms after the beginning of the step.
pub const DECIDE_MS: u64 = 800;
/// Length of a step, ms.
pub(super) const STEP_MS: u64 = DEFAULT_STEP_MS as u64;
