//! Testing and measuring on QEMU.

pub mod console;
pub mod costs;
mod instructions;
pub mod kernel;
mod stack;
