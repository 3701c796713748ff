//! A radio link that is not perfect, and a swarm that flies by it.
//!
//! [`Radio`] carries datagrams between the nodes of a swarm and does to them what
//! [`RadioSettings`] say: it loses, delays, doubles, reorders and damages them, and ends at a
//! range. It knows nothing of what is in them, of sockets or of clocks, so tests, a bridge and
//! an evaluation can all play the same link. [`RadioPolicy`] flies a world's UAVs as boards do:
//! each knows the others only by the messages that such a link brings it. [`RadioObserver`]
//! makes the observations that come of it, for training.
//!
//! What happens to a datagram is a function of the seed, the sender, the receiver and its
//! number among those that this sender sent to this receiver: never of threads or of the order
//! in which the nodes of a swarm have their turns.

mod draws;
mod figures;
mod model;
mod observer;
mod policy;
mod settings;
mod swarm;

pub use figures::{RadioFigures, RadioWorldError, evaluate_over};
pub use model::{Counts, Datagram, MAX_NODES, Radio};
pub use observer::RadioObserver;
pub use policy::RadioPolicy;
pub use settings::{KEYS, RadioError, RadioSettings};
pub use swarm::{DECIDE_MS, ENCODE_MS};
