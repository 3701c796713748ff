//! Metrics files in JSON lines: one object a line, appended and flushed row by row.
//!
//! A row is complete once its newline is written. A process killed in the middle of a row leaves a tail without a
//! newline: [`read`](read()) leaves it out and [`MetricsLog::resume`] cuts it off. Numbers that are not finite become
//! `null`, since JSON has no NaN; [`nan_as_null`] reads them back.

mod error;
mod log;
pub mod nan_as_null;
mod read;

pub use error::MetricsError;
pub use log::MetricsLog;
pub use read::read;
