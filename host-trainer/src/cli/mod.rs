//! The command line: commands, their flags and the help. What the commands do is in
//! [`commands`](crate::commands).

mod bench;
mod device;
mod eval;
mod experiment;
mod files;
mod renamed;
mod root;
mod train;

pub use bench::{Bench, BenchStage};
pub use device::Device;
pub use eval::{Eval, Processor};
pub use experiment::{Experiment, ExperimentPaper, ExperimentRadio};
pub use files::{Export, Inspect, Report};
pub use renamed::{RenamedFlag, with_current_names};
pub use root::{Cli, Command};
pub use train::Train;
