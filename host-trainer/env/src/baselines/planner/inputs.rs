//! What the choice of a target depends on.

use super::known::{Claim, KnownPoi};

/// Parameters of a planner, tuned by hand and by search.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    /// A PoI counts for cell centres within this distance, u.
    pub reach_u: f64,
    /// Within this distance of a refined target a PoI counts in full; from there to the coverage range its weight falls
    /// to a fifth.
    pub sure_u: f64,
    /// Weight of the PoIs expected in an unseen cell from the prior alone.
    pub prior: f64,
    /// Weight of the estimate that unseen PoIs lie near known ones.
    pub near_known: f64,
    /// Density of known PoIs at which that estimate has reached 63 %.
    pub near_known_scale: f64,
    /// Bonus of targets straight ahead.
    pub inertia: f64,
    /// Weight of the claims of UAVs that yield.
    pub yielding_claim: f64,
    /// Bonus of the present target.
    pub hysteresis: f64,
}

/// The state that a UAV chooses its target in, besides the cells (see [`super::local_map::CellColumn`]).
pub(super) struct PlannerInputs<'b> {
    /// The UAV.
    pub id: usize,
    /// Its position, u.
    pub at: (f64, f64),
    /// Its velocity, u/step.
    pub velocity: (f64, f64),
    /// Planning horizon, steps.
    pub horizon: f64,
    /// PoIs that it knows.
    pub pois: &'b [KnownPoi],
    /// Claims of other UAVs.
    pub claims: &'b [Claim],
    /// Share of the PoIs that it does not know.
    pub unknown: f64,
    /// Factor of estimates about unseen cells.
    pub estimate_factor: f64,
    /// Its present target if it may keep it, u.
    pub present_target: Option<(f64, f64)>,
}
