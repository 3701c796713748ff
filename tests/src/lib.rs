//! What the tests of several crates share: tables of bad files, bad folders, broken outputs and signals, which every
//! command of every program is fed. What is read is the exit status and the words.

mod bad_file;
mod held;
mod outputs;
mod table;

pub use bad_file::{BadFile, bad_files, bad_places, bad_values};
pub use held::held;
pub use outputs::Outputs;
pub use table::{End, LEAST_OF_ALL, Table, words};
