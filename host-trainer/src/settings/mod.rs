//! The settings of a training run: what there is, with which defaults and bounds, and how a TOML
//! file or `--set key=value` changes them.
//!
//! [`Settings`] is the table itself. Everything said of a setting elsewhere (the page of
//! `host-trainer settings`, error messages, reports) comes from its documentation and bounds
//! there, by way of [`keys`].

mod choice;
mod error;
mod key;
mod read;
mod renamed;
mod schedule;
mod table;
mod validate;

pub use choice::{Choice, word_of};
pub use error::SettingsError;
pub use key::{Bounds, Key, keys};
pub use renamed::{Renamed, current_name};
pub use table::Settings;

pub(crate) use choice::parser;
