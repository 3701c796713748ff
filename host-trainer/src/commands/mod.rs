//! What the commands do. [`run`] takes what the [command line](crate::cli) parsed.

mod actor;
mod bench;
mod device;
mod dispatch;
mod eval;
mod export;
mod hold;
mod inspect;
mod interrupt;
mod meter;
mod output;
mod paper;
mod pil;
mod radio;
mod report;
mod session;
mod settings;
mod threads;
mod train;

pub use dispatch::run;
pub use output::write_err;
