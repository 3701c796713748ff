//! How much coverage is left over a radio that loses and delays messages: the page
//! `docs/radio-loss.md`.

mod conditions;
mod page;
mod study;

pub use study::{RadioStudy, study, study_agent_steps};
