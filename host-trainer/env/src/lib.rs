//! Covey's scenario: a group of UAVs that covers points of interest (PoIs).
//!
//! A [`World`] is one map with its UAVs and PoIs. It moves them by the action table
//! of [`firmware_core`] and shows each UAV the very observation that the board
//! builds, so nothing about the scenario exists twice. Distances are in map units
//! (u), times in steps.
//!
//! Everything is a function of a seed and a world index, never of the thread that
//! computes it.
#![forbid(unsafe_code)]

mod actor_policy;
mod assignment;
pub mod baselines;
mod bits;
pub mod cover;
mod evaluate;
mod grid;
mod groups;
mod layout;
mod metrics;
mod observation_batch;
mod observer;
pub mod oracles;
mod plane;
mod policy;
pub mod radio;
pub mod random;
mod scenario;
mod score;
mod shipped;
mod snapshot;
mod steering;
mod trace;
mod view;
mod world;

pub use actor_policy::{ActorPolicy, heard};
pub use evaluate::{Evaluation, evaluate, evaluate_with, policy_seed};
pub use metrics::EpisodeMetrics;
pub use observation_batch::{
    BatchedObservation, ObservationBatch, ObservationForm, ObservationSlice, ObservationSliceMut,
};
pub use observer::{Neighbourhood, Observer};
pub use policy::Policy;
pub use scenario::{PoiDistribution, Scenario, ScenarioError};
pub use shipped::{SHIPPED, open_actor};
pub use snapshot::Snapshot;
pub use trace::{Frame, Trace};
pub use world::{PlacementError, World};
