#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod actor_policy;
pub mod baselines;
mod evaluation;
mod observe;
pub mod oracles;
mod plane;
mod policy;
pub mod radio;
pub mod random;
mod scenario;
mod shipped_actors;
mod steering;
mod world;

pub use actor_policy::ActorPolicy;
pub use evaluation::{Evaluation, Frame, Trace, evaluate, evaluate_with, policy_seed};
pub use observe::{
    BatchedObservation, Neighbourhood, ObservationBatch, ObservationForm, ObservationSlice, ObservationSliceMut,
    Observer, neighbour_features,
};
pub use policy::Policy;
pub use scenario::{PoiDistribution, Scenario, ScenarioError};
pub use shipped_actors::{SHIPPED, open_actor};
pub use world::{EpisodeMetrics, PlacementError, Snapshot, World};
