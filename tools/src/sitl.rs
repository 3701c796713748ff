//! `cargo xtask sitl`: the node beside real autopilot firmware in simulation, held to what the documents say.

use std::path::{self, PathBuf};

use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::setup::simlink;
use crate::workspace;

/// Where the autopilots' own documents tell how to build them.
const WHERE: &str = "name a build of yours:\n  \
    --arducopter PROGRAM  ArduPilot's Copter for SITL, build/sitl/bin/arducopter; how to build it: \
    https://ardupilot.org/dev/docs/building-the-code.html\n  \
    --px4 FOLDER          PX4 for SITL, such as build/px4_sitl_default; how to build it: \
    https://docs.px4.io/main/en/dev_setup/building_px4.html";

/// Options of `cargo xtask sitl`.
#[derive(clap::Args)]
pub struct Args {
    /// ArduPilot's Copter, built for SITL.
    #[arg(long, value_name = "PROGRAM")]
    arducopter: Option<PathBuf>,
    /// PX4's build folder for SITL.
    #[arg(long, value_name = "FOLDER")]
    px4: Option<PathBuf>,
    /// Only cases whose name has one of these words.
    #[arg(long, value_name = "WORDS", num_args = 1..)]
    only: Vec<String>,
    /// Cases that fly at the same time.
    #[arg(long, default_value_t = 8)]
    at_once: u8,
}

/// Builds the node, runs the suite and prints its table.
///
/// # Errors
/// No build is named or it is not there, something cannot be set up, or a case was otherwise than documented.
pub fn main(args: &Args) -> Result<()> {
    if args.arducopter.is_none() && args.px4.is_none() {
        return Err(Error::Setup(WHERE.into()));
    }
    // Before anything is installed or built for it.
    let programs = [args.arducopter.clone(), args.px4.as_ref().map(|folder| folder.join("bin/px4"))];
    if let Some(missing) = programs.into_iter().flatten().find(|program| !program.is_file()) {
        return Err(Error::content(&missing, format!("there is no such program; {WHERE}")));
    }
    if !simlink::is_present() {
        simlink::install()?;
    }
    let root = workspace::root();
    Cmd::new(simlink::python())
        .args(["-m", "pip", "install", "--quiet", "--no-input", "--disable-pip-version-check", "--requirement"])
        .arg(root.join("sitl-bridge/sitl/requirements.txt"))
        .read()?;
    Cmd::cargo().args(["build", "--release", "--package", "sitl-bridge"]).read()?;
    let mut suite = Cmd::new(simlink::python())
        .args(["-m", "sitl.acceptance", "--at-once", &args.at_once.to_string(), "--bridge"])
        .arg(workspace::target_folder().join("release/sitl-bridge"));
    for (option, path) in [("--arducopter", &args.arducopter), ("--px4", &args.px4)] {
        if let Some(path) = path {
            // Commands run in the workspace's folder, a path is of the user's.
            suite = suite.arg(option).arg(path::absolute(path).map_err(Error::file(path))?);
        }
    }
    if !args.only.is_empty() {
        suite = suite.arg("--only").args(&args.only);
    }
    suite.run_watched(|_| ())
}
