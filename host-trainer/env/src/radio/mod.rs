//! The radio: a channel model that is not perfect, and swarms whose UAVs exchange their messages over it.
//!
//! [`RadioChannel`] carries datagrams between the nodes of a swarm and loses, delays, duplicates, reorders and corrupts
//! them as [`RadioSettings`] say, within a range. It knows nothing of their content, of sockets or of clocks, so a
//! test, a simulation and an evaluation can all use the same channel. [`RadioPolicy`] flies the UAVs of a world as
//! boards do: each knows of the others only by the messages that the channel delivers. [`RadioObserver`] makes the
//! observations that follow, for training.
//!
//! What happens to a datagram is a function of the seed, the sender, the receiver and its number among the datagrams
//! that this sender sent to this receiver: never of threads or of the order in which the nodes are simulated.

mod channel;
mod counts;
mod datagram_random;
mod error;
mod evaluate;
mod figures;
mod impairments;
mod in_transit;
mod observer;
mod parameters;
mod policy;
mod settings;
mod settings_text;
mod swarm;

pub use channel::{Datagram, RadioChannel};
pub use counts::DatagramCounts;
pub use error::{RadioError, RadioWorldError};
pub use evaluate::evaluate_over_radio;
pub use figures::RadioFigures;
pub use observer::RadioObserver;
pub use parameters::MAX_NODES;
pub use policy::RadioPolicy;
pub use settings::RadioSettings;
pub use swarm::{DECIDE_MS, ENCODE_MS};
