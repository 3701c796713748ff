//! Debian packages.

use std::io::IsTerminal as _;
use std::thread;
use std::time::Duration;

use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::workspace::find_program;

/// How long to wait in all for another package manager to let go of its lock.
const LOCK_TRIES: u32 = 60;
const LOCK_PAUSE: Duration = Duration::from_secs(5);

/// Installs `packages`, with one retry should a download or dpkg stumble.
///
/// # Errors
/// There is no apt-get, we may not install, or the installation failed twice.
pub fn install(packages: &[&str]) -> Result<()> {
    if find_program(&["apt-get"]).is_none() {
        return Err(Error::NotDebian { packages: packages.join(" ") });
    }
    let update = apt_get("update");
    let install = apt_get("install").args(["-y", "--no-install-recommends"]).args(packages);
    if let Some(permitted) = permission()? {
        let as_root =
            |command: &Cmd| if permitted == Permission::Sudo { command.clone().into_root() } else { command.clone() };
        eprintln!("setup: {}", as_root(&install));
        return twice(|| {
            patiently(&as_root(&update))?;
            patiently(&as_root(&install))
        });
    }
    let by_hand =
        format!("sudo apt-get update && sudo apt-get install -y --no-install-recommends {}", packages.join(" "));
    Err(Error::NeedsRoot { command: by_hand })
}

fn apt_get(verb: &str) -> Cmd {
    Cmd::new("apt-get").args(["-q", "-o", "DPkg::Lock::Timeout=300", verb]).env("DEBIAN_FRONTEND", "noninteractive")
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Permission {
    Root,
    Sudo,
}

/// How we may become root; none when only the user can help.
fn permission() -> Result<Option<Permission>> {
    if Cmd::new("id").arg("-u").read()?.trim() == "0" {
        return Ok(Some(Permission::Root));
    }
    let sudo = find_program(&["sudo"]).is_some()
        && (std::io::stdin().is_terminal() || Cmd::new("sudo").args(["-n", "true"]).succeeds());
    Ok(sudo.then_some(Permission::Sudo))
}

/// Tries `action` a second time when it fails.
pub fn twice<T>(mut action: impl FnMut() -> Result<T>) -> Result<T> {
    action().or_else(|error| {
        eprintln!("setup: {error}\nsetup: once more");
        action()
    })
}

/// Runs `command`, and waits as long as another package manager holds the lock: apt's own time-out does not cover
/// the lock of the package lists.
fn patiently(command: &Cmd) -> Result<()> {
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
