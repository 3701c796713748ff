//! A running flight program in QEMU, and the depth of its stack.

use std::fs;
use std::ops::Deref;
use std::path::Path;

use covey_pil::qemu::Qemu;

use super::qmp::Qmp;
use crate::error::{Error, Result};
use crate::targets::elf;
use crate::targets::qemu::Machine;

/// The word with which the program's start-up code (cortex-m-rt) fills the stack.
const PAINT: u32 = 0xcccc_cccc;

/// A QEMU that runs the flight program. Dropping it ends QEMU.
pub struct Session(Qemu);

impl Session {
    /// Starts the flight program with this actor file in the board's flash; with erased flash where there is none.
    ///
    /// # Errors
    /// QEMU does not start.
    pub fn start(machine: Machine, program: &Path, actor: Option<&[u8]>) -> Result<Self> {
        Ok(Self(Qemu::start(machine.board(), program, actor)?))
    }

    /// The deepest stack so far, bytes. It stops the program.
    ///
    /// # Errors
    /// QEMU's monitor does not answer.
    pub fn stack_used(&self, program: &Path) -> Result<u64> {
        let (end, start) = stack_of(program)?;
        let dump = self.folder().join("stack");
        let mut monitor = Qmp::connect(&self.monitor())?;
        monitor.save_memory(end, start - end, &dump)?;
        let ram = fs::read(&dump).map_err(Error::file(&dump))?;
        Ok(deepest(&ram))
    }
}

impl Deref for Session {
    type Target = Qemu;

    fn deref(&self) -> &Qemu {
        &self.0
    }
}

/// The bytes of the stack that have been used: all from the first word that has changed. `ram` is the memory of the
/// stack, which grows towards its beginning.
fn deepest(ram: &[u8]) -> u64 {
    let clean = ram.as_chunks::<4>().0.iter().take_while(|word| u32::from_le_bytes(**word) == PAINT).count();
    (ram.len() - 4 * clean) as u64
}

/// The lowest and the highest address of the stack of a program.
fn stack_of(image: &Path) -> Result<(u64, u64)> {
    Ok((elf::address_of(image, "_stack_end")?, elf::address_of(image, "_stack_start")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_stack_ends_at_the_last_paint() {
        let mut ram = vec![0xcc; 64];
        assert_eq!(deepest(&ram), 0);
        ram[60..].fill(1);
        assert_eq!(deepest(&ram), 4);
        // What looks like paint in the middle was used all the same.
        ram[20] = 0;
        assert_eq!(deepest(&ram), 44);
        assert_eq!(deepest(&[0; 8]), 8);
    }
}
