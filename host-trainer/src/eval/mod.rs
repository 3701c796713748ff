//! Evaluation: policies on held-out worlds, as the int8 actor flies and as the float network
//! does, over a radio that loses messages, and decided by a processor in the loop.

mod agreement;
mod any_actor;
mod config;
mod over_radio;
pub mod pil;
mod policy;
mod reference;
mod row;
mod table;
mod watch;

pub use agreement::{Agreement, argmax_agreement};
pub use any_actor::{AnyActor, UnsoundActor};
pub use config::EvalConfig;
pub use over_radio::evaluate_with_radio;
pub use policy::EvalPolicy;
pub use reference::ReferencePolicy;
pub use row::{EvalRow, EvaluationFile, PilFigures, RadioRow};
pub use table::{radio_table, table};
pub use watch::{UNWATCHED, Watch};

pub(crate) use any_actor::with_actor;
