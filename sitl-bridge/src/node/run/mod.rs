//! A running node: sockets and one thread around the state machine.

mod control;
mod event;
mod event_loop;

pub use control::{Links, RunControl};
pub use event::NodeEvent;
pub use event_loop::run;
