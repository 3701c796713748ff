//! The quantised actor.
//!
//! Network (paper, sections 2.2 and 3.2; all activations int8):
//!
//! ```text
//! observation (160) → encoder 1 → ReLU → encoder 2 → ReLU → h (64)       encode: once a step
//! neighbours' h, own h → aggregate → graph layer → ReLU → y (64)          none | GCN | GAT | GATv2 | SAGE
//! [h ‖ y] → head → ReLU → output → 17 logits                              decide
//! ```
//!
//! `h` is what a UAV broadcasts. For GAT the score of equation (6) splits into a term
//! of the receiver and one of the sender, so a sender adds one number, its half. With GATv2
//! a sender broadcasts `W_r h` instead, which the receiver scores and sums; there is no graph layer.
//! Everything is read in place from the actor file; the actor itself is a few
//! slices.

mod aggregation;
mod aggregator;
mod dimensions;
mod feature;
pub mod file;
mod fingerprint;
mod graph;
mod input_layer;
pub mod layer;
mod policy_id;
mod provenance;
mod quantised;
mod self_test;
pub mod softmax;

pub use aggregation::Aggregation;
pub use dimensions::Dimensions;
pub use feature::{Feature, MAX_DEGREE, MAX_FEATURE, NeighbourFeature};
pub use file::LoadError;
pub use fingerprint::{FINGERPRINT_CASES, Fingerprint, fingerprint};
pub use graph::RECEIVER_MAX;
pub use input_layer::{ActorInput, SparseLayer};
pub use policy_id::PolicyId;
pub use provenance::Provenance;
pub use quantised::{Actor, CellsActor, QuantisedActor};
pub use self_test::{SELF_TESTS, SelfTest, SelfTestError, write_self_test};
pub use softmax::{Logits, Mode, argmax, sample};
