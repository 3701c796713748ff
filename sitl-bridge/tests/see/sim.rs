//! Simulated flights through the command line.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

/// The Python environment of the simulated autopilots.
pub fn python() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().expect("the workspace").join(".venv/bin/python")
}

/// Runs the bridge.
pub fn bridge(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sitl-bridge"));
    command.args(args).output().expect("sitl-bridge starts")
}

/// What a run printed for people.
pub fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

/// Flies world 0 with these options and the recordings in a folder.
pub fn fly(options: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (tlog, python) = (folder.path().to_str().expect("text"), python());
    let mut args = vec!["swarm", "--sim", "--pois", "30", "--tlog", tlog, "--python", python.to_str().expect("text")];
    args.extend(options);
    let output = bridge(&args);
    assert!(output.status.success(), "`cargo xtask setup simlink` makes what this needs.\n{}", words(&output));
    folder
}

/// UAVs in the flight that several tests look at.
pub const UAVS: u16 = 10;

/// That flight.
pub fn flown() -> &'static Path {
    static FLOWN: OnceLock<TempDir> = OnceLock::new();
    FLOWN.get_or_init(|| fly(&["--count", &UAVS.to_string(), "--steps", "12"])).path()
}

/// A UAV's recording in such a folder.
pub fn tlog(folder: &Path, uav: u16) -> PathBuf {
    folder.join(format!("world-0-uav-{uav}.tlog"))
}
