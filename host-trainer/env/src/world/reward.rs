//! The reward of one UAV in one state (section 3.1 of the paper; see `docs/scenario.md`).

use firmware_core::geometry::SPEED_CAP_U;

/// Within this distance of the edge (the limit is inside) a UAV pays the border cost, u.
const BORDER_U: f32 = 5.0;
/// Reward of a UAV that covers no PoI alone in its group.
const NONE_ALONE: f32 = -1.0;
/// Cost of being near the edge.
const BORDER_COST: f32 = 1.0;
/// Share of the group's other PoIs in a UAV's reward.
const GROUP_SHARE: f32 = 0.1;

/// Energy of one step at the velocity (`vx`, `vy`), u/step: 0.5 hovering, 1 at full speed, linear in the speed.
pub(crate) fn step_energy(vx: f32, vy: f32) -> f32 {
    0.5 + 0.5 / SPEED_CAP_U as f32 * libm::sqrtf(vx * vx + vy * vy)
}

/// Whether (x, y) is within 5 u of the edge.
pub(crate) fn near_border(side_u: f32, x: f32, y: f32) -> bool {
    let clear = |v: f32| v > BORDER_U && v < side_u - BORDER_U;
    !(clear(x) && clear(y))
}

/// Reward of a UAV that alone covers `individual` of the `group` PoIs that its group of `size` members covers, having
/// spent `energy`: the paper's reward, its group term averaged over the other members.
pub(crate) fn uav_reward(individual: u32, group: u32, size: u32, near_border: bool, energy: f32) -> f32 {
    let own = if individual == 0 { NONE_ALONE } else { individual as f32 };
    let shared = if size > 1 { GROUP_SHARE * (group - individual) as f32 / (size - 1) as f32 } else { 0.0 };
    let border = if near_border { BORDER_COST } else { 0.0 };
    (own + shared - border) / energy
}
