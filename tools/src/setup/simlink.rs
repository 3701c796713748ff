//! The Python environment of the simulated autopilots: `.venv` in the workspace, with the packages that
//! `sitl-bridge/simlink/requirements.txt` pins.

use std::fs;
use std::path::PathBuf;

use super::apt::twice;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::output::tell;
use crate::workspace;

/// The path of the environment's Python.
pub fn python() -> PathBuf {
    venv().join("bin/python")
}

/// The folder of the environment.
fn venv() -> PathBuf {
    workspace::root().join(".venv")
}

/// The file with the packages and their versions.
fn requirements() -> PathBuf {
    workspace::root().join("sitl-bridge/simlink/requirements.txt")
}

/// A copy of the requirements that were installed last; it is written when the installation is complete.
fn installed() -> PathBuf {
    venv().join("covey-requirements.txt")
}

/// Whether the environment has the packages of the present requirements, and they can be imported from any folder.
pub fn is_present() -> bool {
    let same = fs::read(requirements()).is_ok_and(|wanted| fs::read(installed()).is_ok_and(|have| have == wanted));
    same && Cmd::new(python()).args(["-c", "import pymavlink, fastcrc, simlink"]).folder("/").succeeds()
}

/// Makes the environment, or brings it up to date. Python with venv and pip must be installed.
///
/// # Errors
/// The environment cannot be made, or a download failed twice.
pub fn install() -> Result<()> {
    // An environment whose Python is gone, as after an upgrade of the system, is made anew.
    let clear: &[&str] =
        if Cmd::new(python()).args(["-m", "pip", "--version"]).succeeds() { &[] } else { &["--clear"] };
    Cmd::new("python3").args(["-m", "venv"]).args(clear).arg(venv()).read()?;
    let pip = Cmd::new(python())
        .args(["-m", "pip", "install", "--quiet", "--no-input", "--disable-pip-version-check", "--requirement"])
        .arg(requirements());
    tell!("setup: {pip}");
    twice(|| pip.read())?;
    let site = Cmd::new(python()).args(["-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]).read()?;
    let path_file = PathBuf::from(site.trim()).join("simlink.pth");
    let package = workspace::root().join("sitl-bridge");
    fs::write(&path_file, format!("{}\n", package.display())).map_err(Error::file(&path_file))?;
    // This is the last step, so that an interrupted installation is not taken for a complete one.
    fs::copy(requirements(), installed()).map_err(Error::file(installed()))?;
    Ok(())
}
