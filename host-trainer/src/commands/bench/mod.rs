//! `bench`: how fast this machine plays and learns, and how near that is to what it could.

mod against;
mod command;
mod machine;
mod median;
mod report;

pub use command::run;
