//! `experiment paper`: trains what is missing, flies it, writes the report.

mod command;
mod plan;
mod progress;
mod training;

pub use command::run;
