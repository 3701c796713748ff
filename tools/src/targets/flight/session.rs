//! One run of the flight program in QEMU, and how deep its stack went.

use std::fs;
use std::ops::Deref;
use std::path::Path;

use covey_pil::qemu::Qemu;

use super::super::qemu::Machine;
use super::qmp::Qmp;
use super::{deepest, stack_of};
use crate::error::{Error, Result};

/// What the program's start-up code fills its stack with (cortex-m-rt).
const PAINT: u32 = 0xcccc_cccc;

/// A running QEMU; it ends with this value.
pub struct Session(Qemu);

impl Session {
    /// Starts the program with this actor file in its flash.
    ///
    /// # Errors
    /// QEMU does not start.
    pub fn start(machine: Machine, program: &Path, actor: Option<&[u8]>) -> Result<Self> {
        Ok(Self(Qemu::start(machine.board(), program, actor)?))
    }

    /// The deepest stack so far, bytes; stops the program.
    ///
    /// # Errors
    /// QEMU's monitor does not answer.
    pub fn stack_used(&self, program: &Path) -> Result<u64> {
        let (end, start) = stack_of(program)?;
        let dump = self.folder().join("stack");
        let mut monitor = Qmp::connect(&self.monitor())?;
        monitor.save_memory(end, start - end, &dump)?;
        let ram = fs::read(&dump).map_err(Error::file(&dump))?;
        Ok(deepest(&ram, PAINT))
    }
}

impl Deref for Session {
    type Target = Qemu;

    fn deref(&self) -> &Qemu {
        &self.0
    }
}
