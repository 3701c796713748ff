//! Installing Debian packages.

use std::io::IsTerminal as _;
use std::thread;
use std::time::Duration;

use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::output::tell;
use crate::workspace::find_program;

/// How often to try again while another package manager holds the lock.
const LOCK_TRIES: u32 = 60;
/// How long to wait before each of these tries.
const LOCK_PAUSE: Duration = Duration::from_secs(5);

/// Installs `packages`. When that fails it is tried once more.
///
/// # Errors
/// There is no apt-get, the user is not allowed to install packages, or the installation failed twice.
pub fn install(packages: &[&str]) -> Result<()> {
    if find_program(&["apt-get"]).is_none() {
        return Err(Error::NotDebian { packages: packages.join(" ") });
    }
    let update = apt_get("update");
    let install = apt_get("install").args(["-y", "--no-install-recommends"]).args(packages);
    if let Some(permitted) = permission()? {
        let as_root =
            |command: &Cmd| if permitted == Permission::Sudo { command.clone().into_root() } else { command.clone() };
        tell!("setup: {}", as_root(&install));
        return twice(|| {
            run_when_unlocked(&as_root(&update))?;
            run_when_unlocked(&as_root(&install))
        });
    }
    let by_hand =
        format!("sudo apt-get update && sudo apt-get install -y --no-install-recommends {}", packages.join(" "));
    Err(Error::NeedsRoot { command: by_hand })
}

/// A command of apt-get that asks no questions.
fn apt_get(verb: &str) -> Cmd {
    Cmd::new("apt-get").args(["-q", "-o", "DPkg::Lock::Timeout=300", verb]).env("DEBIAN_FRONTEND", "noninteractive")
}

/// How a command can be run as root.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Permission {
    /// The user is root.
    Root,
    /// By sudo.
    Sudo,
}

/// How commands can be run as root; `None` where sudo is missing, or would ask for a password without a terminal.
fn permission() -> Result<Option<Permission>> {
    if Cmd::new("id").arg("-u").read()?.trim() == "0" {
        return Ok(Some(Permission::Root));
    }
    let sudo = find_program(&["sudo"]).is_some()
        && (std::io::stdin().is_terminal() || Cmd::new("sudo").args(["-n", "true"]).succeeds());
    Ok(sudo.then_some(Permission::Sudo))
}

/// Runs `action`, and once more when it fails.
///
/// # Errors
/// The second run failed.
pub fn twice<T>(mut action: impl FnMut() -> Result<T>) -> Result<T> {
    action().or_else(|error| {
        tell!("setup: {error}\nsetup: once more");
        action()
    })
}

/// Runs `command`, and again while another package manager holds the lock: apt's own time-out does not cover the lock
/// of the package lists.
fn run_when_unlocked(command: &Cmd) -> Result<()> {
    let mut tries = 0;
    loop {
        match command.read() {
            Ok(_) => return Ok(()),
            Err(Error::Failed { output, .. }) if output.contains("Could not get lock") && tries < LOCK_TRIES => {
                tries += 1;
                thread::sleep(LOCK_PAUSE);
            }
            Err(error) => return Err(error),
        }
    }
}
