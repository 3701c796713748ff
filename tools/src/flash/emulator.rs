//! The boards that QEMU emulates: they run the same program and actor file as a real board.

use super::actor_file::ActorFile;
use super::progress::say;
use super::serial::verify;
use crate::error::Result;
use crate::output::print;
use crate::setup;
use crate::targets::artefacts::{Board, Image};
use crate::targets::flight::{PATIENCE, session::Session};
use crate::targets::{NEEDS, qemu::Machine};

pub use crate::targets::qemu::Machine::{CortexM4f as M4F, CortexM7 as M7};

/// Starts the flight program in QEMU with the actor file in its flash, and checks over the PIL protocol that it runs
/// this actor and computes what this computer computes. With `dry_run` it only prints the command.
///
/// # Errors
/// A build failed, QEMU does not start, or the emulated board computes something else.
pub fn flash(machine: Machine, actor: &ActorFile, dry_run: bool) -> Result<()> {
    if dry_run {
        say("would run, after building the program for it:");
        print(&format!("  {}\n", machine.run("flight".as_ref(), Some(&actor.path))))?;
        return Ok(());
    }
    setup::install(NEEDS)?;
    say("building the program");
    let image = Image::build(Board::Mps2)?;
    say(&format!("starting it on {}", machine.target()));
    let session = Session::start(machine, &image.flight, Some(&actor.bytes))?;
    verify(&mut session.client(PATIENCE)?, machine.target(), actor)
}
