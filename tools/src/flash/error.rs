//! The errors of flashing. Each message says what to do next.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Why something could not be flashed.
#[derive(Debug, thiserror::Error)]
pub enum FlashError {
    /// probe-rs is not installed.
    #[error("probe-rs is not installed; get it with:\n  cargo install probe-rs-tools --locked")]
    NoProbeRs,
    /// No probe is connected.
    #[error(
        "no debug probe found; connect the board's ST-LINK connector (CN1) to this computer with a cable that carries data, and see whether `probe-rs list` shows it"
    )]
    NoProbe,
    /// A probe is connected, but the user is not allowed to open it.
    #[error(
        "a debug probe is connected, but you may not use it; install the udev rules of https://probe.rs/docs/getting-started/probe-setup, then:\n  sudo udevadm control --reload && sudo udevadm trigger\nand plug it in again"
    )]
    NoPermission,
    /// The chip on the board is not the one that the image is for.
    #[error(
        "the chip on this board is not an STM32H743 or STM32H753: its device id is {found:#05x}, theirs {expected:#05x}; choose the right --board, or connect the right one"
    )]
    WrongChip {
        /// Device id of the chip on the board.
        found: u32,
        /// Device id of the chip that the image is for.
        expected: u32,
    },
    /// The file is not a valid actor file, or its self-test fails.
    #[error("{}: {reason}", path.display())]
    WrongFile {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
    /// Several probes are connected, and none was chosen.
    #[error("several debug probes are connected; choose one by --probe and its VID:PID:SERIAL:\n{list}")]
    ManyProbes {
        /// What probe-rs lists.
        list: String,
    },
    /// The actor file's address is no number.
    #[error("COVEY_ACTOR_ADDRESS={0} is no address: write it as 0x08040000, or unset it")]
    BadAddress(String),
    /// `--host` names no computer.
    #[error("--host {given}: {what}; write user@host, user@host:port, user@[IPv6]:port or ssh://user@host:port")]
    BadHost {
        /// As given.
        given: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A step failed after others had changed the target.
    #[error("{cause}\n{state}")]
    Unfinished {
        /// What failed.
        cause: String,
        /// What is on the target now, and what to do.
        state: String,
    },
    /// probe-rs failed in another way.
    #[error(
        "`{command}` failed; is the board powered, and does nothing else (a debugger, an IDE) use its probe?\n{output}"
    )]
    Probe {
        /// The command that failed.
        command: String,
        /// Its output.
        output: String,
    },
    /// The other computer cannot be reached.
    #[error("no login by ssh without a password; try `ssh {host} true`, and `ssh-copy-id {host}`\n{output}")]
    NoHost {
        /// The computer, as user@host.
        host: String,
        /// The output of ssh.
        output: String,
    },
    /// No node is built for the processor of the other computer.
    #[error("{host} is a {machine}; nodes are built for aarch64 and x86_64")]
    WrongMachine {
        /// The computer, as user@host.
        host: String,
        /// Its processor, as `uname -m` prints it.
        machine: String,
    },
    /// The target computes another signature than this computer.
    #[error(
        "the actor's signature is {found} on {place}, but {expected:016x} here: do not fly it there; flash again, and check its memory"
    )]
    Signature {
        /// The name of the board or computer.
        place: String,
        /// The signature that it computed, in hexadecimal digits.
        found: String,
        /// The signature that this computer computed.
        expected: u64,
    },
    /// The board runs another actor.
    #[error("{place} runs actor {found:016x}, not {expected:016x}; flash it again, or reset it")]
    OtherActor {
        /// The name of the board.
        place: String,
        /// Content hash of the actor on the board.
        found: u64,
        /// Content hash of the actor in the file.
        expected: u64,
    },
}

impl FlashError {
    /// Says of an error what is on the target already.
    pub fn unfinished(cause: &dyn Display, state: &str) -> Self {
        Self::Unfinished { cause: cause.to_string(), state: state.to_owned() }
    }

    /// Wraps the reason why a file is not a valid actor file.
    pub fn wrong_file(path: &Path, reason: &dyn Display) -> Self {
        Self::WrongFile { path: path.into(), reason: reason.to_string() }
    }
}
