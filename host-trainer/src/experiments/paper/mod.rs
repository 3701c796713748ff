//! The paper's experiments repeated: three algorithms over several seeds, their curves over
//! training, the trained policies with other numbers of UAVs, and what the paper says of them
//! judged by stated rules.
//!
//! [`collect()`] turns run folders into [`Results`]; figures, tables and verdicts
//! follow from those alone, so that the page can be made again without the runs.

mod claims;
mod collect;
mod compare;
mod design;
mod error;
mod figures;
mod judge;
mod kind;
mod metric;
mod quantity;
mod report;
mod results;
mod runs;
mod statistics;
mod tables;

pub use claims::{CLAIMS, Claim};
pub use collect::{BASELINES, Worlds, collect};
pub use design::{SIZES, WORLDS, title};
pub use error::CollectError;
pub use figures::figures;
pub use judge::{Criterion, Finding, Verdict, judge};
pub use kind::{Kind, QUICK};
pub use metric::Metric;
pub use quantity::{Measure, Quantity, When};
pub use report::page;
pub use results::{Baseline, Curves, Flight, Group, Results, ResultsError, RunResult};
pub use runs::{Run, check, finished, folder_of, run_name, runs};
pub use statistics::Interval;
