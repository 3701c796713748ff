//! The compact observation's form: its id, its length and where its parts lie.

/// Identifies this form of the observation in actor files.
pub const ID: u16 = 2;
/// Neighbours described in the observation (the nearest).
pub(super) const DESCRIBED_NEIGHBOURS: usize = 6;
/// PoIs described in the observation (the nearest).
pub(super) const DESCRIBED_POIS: usize = 22;
/// Length of an observation.
pub const LEN: usize = OWN + PLACES + DESCRIBED_NEIGHBOURS * PER_NEIGHBOUR + DESCRIBED_POIS * PER_POI;
/// Index of the change of velocity that flies to the target, east and north, in 8 u/step / 127.
pub const TARGET_VELOCITY_CHANGE: usize = OWN + SUMS + CANDIDATES + 5;

/// Numbers about the UAV itself.
pub(super) const OWN: usize = 7;
/// Numbers that sum up the surroundings: mean offset of the available PoIs, and separation.
pub(super) const SUMS: usize = 4;
/// Candidate places whose value is given.
pub(super) const CANDIDATES: usize = 17;
/// Numbers about the target.
pub(super) const TARGET: usize = 8;
/// Numbers about the surroundings, the candidate places and the target.
pub(super) const PLACES: usize = SUMS + CANDIDATES + TARGET;
/// Numbers about a neighbour.
pub(super) const PER_NEIGHBOUR: usize = 6;
/// Numbers about a PoI.
pub(super) const PER_POI: usize = 4;

/// One observation: [`LEN`] values in 1/127 of their scales.
pub type Observation = [i8; LEN];
