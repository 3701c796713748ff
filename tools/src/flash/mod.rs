//! `cargo xtask flash`: puts the program and an actor file on a board, or the node and the file on a computer.

mod actor_file;
mod destination;
mod emulator;
mod error;
mod host;
mod probe;
mod progress;
mod serial;
#[cfg(test)]
mod test_support;

use std::path::PathBuf;

use clap::ValueEnum;
use firmware_core::actor::FINGERPRINT_CASES;

use crate::error::Result;
use actor_file::ActorFile;
pub use error::FlashError;
use progress::say;

/// Options of `cargo xtask flash`.
#[derive(clap::Args)]
#[command(group(clap::ArgGroup::new("where").required(true).args(["board", "host"])))]
pub struct Args {
    /// The board to flash.
    #[arg(long, value_enum)]
    board: Option<Board>,
    /// The computer to install on, by ssh: user@host, user@host:port, `user@[IPv6]:port` or ssh://….
    #[arg(long, value_name = "USER@HOST")]
    host: Option<String>,
    /// The actor file to put there.
    #[arg(long, value_name = "FILE")]
    actor: PathBuf,
    /// Leave the board's program as it is and write only the actor file.
    #[arg(long, requires = "board")]
    actor_only: bool,
    /// The board's serial port, to ask over the PIL protocol what it runs now: /dev/ttyACM0.
    #[arg(long, requires = "board", value_name = "DEVICE")]
    port: Option<PathBuf>,
    /// The debug probe, where several are connected: VID:PID:SERIAL, as `probe-rs list` prints it.
    #[arg(long, requires = "board", value_name = "PROBE")]
    probe: Option<String>,
    /// Only print what would be done.
    #[arg(long)]
    dry_run: bool,
}

/// A board that can be flashed, real or emulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Board {
    /// ST's NUCLEO-H743ZI and -H743ZI2, by probe-rs over their USB connector.
    NucleoH743zi,
    /// A Cortex-M7 in QEMU.
    QemuM7,
    /// A Cortex-M4F in QEMU.
    QemuM4f,
}

/// Checks the actor file, flashes it, and checks that the target runs it.
///
/// # Errors
/// The file is not a valid actor file, flashing failed (see [`FlashError`]), or a build failed.
pub fn main(args: &Args) -> Result<()> {
    let actor = ActorFile::read(&args.actor)?;
    say(&format!("{}: sound, actor {:016x}", actor.path.display(), actor.content_hash));
    match (&args.board, &args.host) {
        (Some(Board::NucleoH743zi), _) => {
            probe::Probe::new("probe-rs", args.probe.clone()).flash(&actor, args.actor_only, args.dry_run)?;
            match &args.port {
                Some(port) => serial::check(&actor, port, args.dry_run),
                None => Ok(()),
            }
        }
        (Some(Board::QemuM7), _) => emulator::flash(emulator::M7, &actor, args.dry_run),
        (Some(Board::QemuM4f), _) => emulator::flash(emulator::M4F, &actor, args.dry_run),
        (None, Some(host)) => host::Host::new(host, "ssh", "scp")?.install(&actor, FINGERPRINT_CASES, args.dry_run),
        // The argument group requires one of the two.
        (None, None) => Ok(()),
    }
}
