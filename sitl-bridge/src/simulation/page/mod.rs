//! The HTML page of a simulation.

mod builder;
mod episodes;
mod tables;

pub use builder::{Page, PageError};
