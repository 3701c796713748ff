//! What people see of a flight: recordings that other tools read, and that can be decided again.

mod outlet;
mod page;
mod recording;
mod replay;
mod sim;
mod view;
