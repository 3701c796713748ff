//! QEMU's Cortex-M boards.

use std::collections::BTreeMap;
use std::path::Path;

use covey_pil::qemu;

use super::artefacts::Image;
use crate::command::Cmd;
use crate::error::{Error, Result};

/// No measurement takes longer on the slowest machine, seconds.
const TIME_LIMIT: u32 = 600;

/// One of QEMU's boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// mps2-an500.
    CortexM7,
    /// mps2-an386.
    CortexM4f,
}

impl Machine {
    /// Both.
    pub const ALL: [Self; 2] = [Self::CortexM7, Self::CortexM4f];

    /// Name of the target in tables.
    pub const fn target(self) -> &'static str {
        match self {
            Self::CortexM7 => "cortex-m7",
            Self::CortexM4f => "cortex-m4f",
        }
    }

    /// The board that the link's crate starts.
    pub const fn board(self) -> qemu::Machine {
        match self {
            Self::CortexM7 => qemu::Machine::CortexM7,
            Self::CortexM4f => qemu::Machine::CortexM4f,
        }
    }

    /// QEMU, ready to run `program`, with `actor` in its flash.
    pub fn run(self, program: &Path, actor: Option<&Path>) -> Cmd {
        Cmd::new(qemu::PROGRAM).args(self.board().arguments(program, actor))
    }

    /// Compares the assembly kernel with its portable twin on this many layers.
    ///
    /// # Errors
    /// They differ.
    pub fn check_kernel(self, image: &Image, cases: u32) -> Result<()> {
        self.measure(image, None, &["kernel", &cases.to_string()], false).map(|_| ())
    }

    /// Compares the safety gate's verdicts with this computer's.
    ///
    /// # Errors
    /// They differ, or the run failed.
    pub fn check_gate(self, image: &Image) -> Result<()> {
        let ticks = firmware_core::gate::FINGERPRINT_TICKS;
        let results = self.measure(image, None, &["gate", &ticks.to_string()], false)?;
        let (board, here) = (results.number("signature", 16)?, firmware_core::gate::fingerprint(ticks));
        if board == here {
            return Ok(());
        }
        Err(Error::Figures(format!("{}: the gate's signature is {board:016x}, here it is {here:016x}", self.target())))
    }

    /// The signature of an actor.
    ///
    /// # Errors
    /// The run failed.
    pub fn signature(self, image: &Image, actor: &Path, cases: u32) -> Result<u64> {
        let results = self.measure(image, Some(actor), &["signature", &cases.to_string()], false)?;
        results.number("signature", 16)
    }

    /// What the parts of a decision cost: names and instruction counts or bytes.
    ///
    /// # Errors
    /// The run failed.
    pub fn costs(self, image: &Image, actor: &Path) -> Result<Results> {
        self.measure(image, Some(actor), &["costs"], true)
    }

    fn measure(self, image: &Image, actor: Option<&Path>, words: &[&str], exact: bool) -> Result<Results> {
        let mut semihosting = "enable=on,target=native,arg=measure".to_owned();
        for word in words {
            semihosting += &format!(",arg={word}");
        }
        let mut command = self.run(&image.measure, actor);
        command = command.args(["-serial", "null", "-semihosting-config", &semihosting]);
        if exact {
            // 1024 ns of the machine's time an instruction: see the image's instruction counter.
            command = command.args(["-icount", "shift=10"]);
        }
        // The program's text comes on QEMU's error output.
        let command = command.within(TIME_LIMIT);
        let printed = command.read_all()?;
        let lines = printed.lines().filter_map(|line| line.split_once(' '));
        let values = lines.map(|(name, value)| (name.to_owned(), value.trim().to_owned())).collect();
        Ok(Results { command: command.to_string(), printed, values })
    }
}

/// What a measurement printed.
pub struct Results {
    command: String,
    printed: String,
    values: BTreeMap<String, String>,
}

impl Results {
    /// The decimal number of this name.
    ///
    /// # Errors
    /// It was not printed.
    pub fn count(&self, name: &str) -> Result<u64> {
        self.number(name, 10)
    }

    fn number(&self, name: &str, radix: u32) -> Result<u64> {
        let value = self.values.get(name).and_then(|value| u64::from_str_radix(value, radix).ok());
        value.ok_or_else(|| Error::Output { command: self.command.clone(), printed: self.printed.clone() })
    }
}
