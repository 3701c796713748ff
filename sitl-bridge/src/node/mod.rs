//! A node: it flies one UAV.
//!
//! [`Node`] is a state machine that owns neither sockets nor clocks nor threads. It is handed what
//! arrived, with the time, and returns what to send; so every flight can be played in a test.
//! [`mod@run`] puts sockets and a thread around it.

mod autopilot_link;
mod counters;
mod decision;
mod decision_loop;
mod decision_step;
mod ending;
mod gate_driver;
mod gate_inputs;
mod height_check;
mod host_clock;
mod host_time;
mod link_monitor;
mod logbook;
mod muster;
mod operator;
mod operator_requests;
mod output;
mod refusals;
mod roll_call;
pub mod run;
mod settings;
mod start_check;
mod state_machine;
mod status;
mod step_timing;
mod timebase;
mod velocity_profile;

pub use counters::Counters;
pub use decision::{Decision, StepStart, observation_hash};
pub use host_time::HostTime;
pub use operator::OperatorCommand;
pub use output::NodeOutput;
pub use settings::{Settings, SettingsError, gate_limits};
pub use state_machine::Node;
pub use status::Status;
pub use step_timing::{Pace, StepTiming};
pub use velocity_profile::{FeedForward, VelocityProfile};
