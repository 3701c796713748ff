//! What can go wrong when flashing; each with the next thing to do.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Why something could not be flashed.
#[derive(Debug, thiserror::Error)]
pub enum FlashError {
    /// probe-rs is not there.
    #[error("probe-rs is not installed; get it with:\n  cargo install probe-rs-tools --locked")]
    NoProbeRs,
    /// No probe is connected.
    #[error(
        "no debug probe found; connect the board's ST-LINK connector (CN1) to this computer with a cable that carries data, and see whether `probe-rs list` shows it"
    )]
    NoProbe,
    /// A probe is connected, but may not be opened.
    #[error(
        "a debug probe is connected, but you may not use it; install the udev rules of https://probe.rs/docs/getting-started/probe-setup, then:\n  sudo udevadm control --reload && sudo udevadm trigger\nand plug it in again"
    )]
    NoPermission,
    /// The chip is another one.
    #[error(
        "the chip on this board is not an STM32H743 or STM32H753: its device id is {found:#05x}, theirs {expected:#05x}; choose the right --board, or connect the right one"
    )]
    WrongChip {
        /// Its device id.
        found: u32,
        /// Device id of the chip that the image is for.
        expected: u32,
    },
    /// The file is not an actor that may fly.
    #[error("{}: {reason}", path.display())]
    WrongFile {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
    /// probe-rs failed in another way.
    #[error(
        "`{command}` failed; is the board powered, and does nothing else (a debugger, an IDE) use its probe?\n{output}"
    )]
    Probe {
        /// What was run.
        command: String,
        /// What it said.
        output: String,
    },
    /// The other computer cannot be reached.
    #[error("cannot reach {host} by ssh without a password; try `ssh {host} true`, and `ssh-copy-id {host}`\n{output}")]
    NoHost {
        /// user@host.
        host: String,
        /// What ssh said.
        output: String,
    },
    /// The other computer is of a kind that no node is built for.
    #[error("{host} is a {machine}; nodes are built for aarch64 and x86_64")]
    WrongMachine {
        /// user@host.
        host: String,
        /// What it calls itself.
        machine: String,
    },
    /// The target computes otherwise.
    #[error(
        "the actor's signature is {found} on {place}, but {expected:016x} here: do not fly it there; flash again, and check its memory"
    )]
    Signature {
        /// The board or computer.
        place: String,
        /// What it computed.
        found: String,
        /// What is right.
        expected: u64,
    },
    /// The board runs another actor.
    #[error("{place} runs actor {found:016x}, not {expected:016x}; flash it again, or reset it")]
    OtherActor {
        /// The board.
        place: String,
        /// Its actor's content hash.
        found: u64,
        /// That of the file.
        expected: u64,
    },
}

impl FlashError {
    /// A file that is no actor that may fly.
    pub fn wrong_file(path: &Path, reason: &dyn Display) -> Self {
        Self::WrongFile { path: path.into(), reason: reason.to_string() }
    }
}
