//! Export: from the trained float policy to the int8 actor file, with calibration, quantisation,
//! self-tests and the measured figures.

mod actor_file;
mod calibrate;
mod error;
mod graph;
mod layers;
mod quantise;

pub use actor_file::{ExportedActor, export_actor, export_actor_watched, export_agent_steps};
pub use calibrate::{Ranges, Situation, calibrate};
pub use error::QuantiseError;
pub use quantise::{quantise, situation_agreement};
