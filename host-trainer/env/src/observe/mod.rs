//! What each UAV observes, and of whom it takes features: the inputs of a policy.

mod batch;
mod features;
mod form;
mod neighbourhood;
mod observer;

pub use batch::{BatchedObservation, ObservationBatch, ObservationSlice, ObservationSliceMut};
pub use features::neighbour_features;
pub use form::ObservationForm;
pub use neighbourhood::Neighbourhood;
pub(crate) use neighbourhood::assert_one_each;
pub use observer::Observer;
