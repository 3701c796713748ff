//! The paper's experiments repeated: three algorithms over several seeds, their curves over
//! training, the trained policies with other numbers of UAVs, and what the paper says of them
//! judged by stated rules.
//!
//! [`collect`](mod@collect) turns run folders into [`Results`]; figures, tables and verdicts
//! follow from those alone, so that the page can be made again without the runs.

mod claims;
pub mod collect;
mod compare;
mod design;
mod figures;
mod judge;
mod kind;
mod quantity;
mod report;
mod results;
pub mod statistics;
mod tables;

pub use claims::{CLAIMS, Claim};
pub use design::{SIZES, WORLDS, title};
pub use figures::figures;
pub use judge::{Bar, Finding, Verdict, judge};
pub use kind::{Kind, QUICK};
pub use quantity::{Measure, Quantity, When};
pub use report::page;
pub use results::{Baseline, Curves, Flight, Group, Metric, Results, ResultsError, RunResult};
