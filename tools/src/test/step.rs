//! The steps of the test run.

use super::tally::Tally;
use crate::command::Cmd;
use crate::counts;
use crate::error::Result;
use crate::output::show;
use crate::setup::Item;
use crate::setup::rust_targets::{CORTEX_M, Toolchain};
use crate::setup::simlink;
use crate::targets;

/// A step of the test run: a command that must succeed.
pub struct Step {
    /// The step's name on the command line and in the summary.
    pub name: &'static str,
    /// What must be installed before the step runs.
    pub needs: &'static [Item],
    /// The arguments of the command.
    args: &'static [&'static str],
    /// The name and the value of an environment variable.
    env: Option<(&'static str, &'static str)>,
    /// Whether the command is the Python of the simulated autopilots instead of cargo.
    python: bool,
    /// Whether the step runs clippy for Cortex-M. It is left out where the library for Cortex-M comes from Debian,
    /// whose compiler has no clippy.
    lints_image: bool,
}

impl Step {
    /// A step that runs cargo.
    const fn cargo(name: &'static str, args: &'static [&'static str]) -> Self {
        Self { name, needs: &[], args, env: None, python: false, lints_image: false }
    }
}

/// The manifest of the images, which are a workspace of their own.
const IMAGE: &str = "firmware-core/image/Cargo.toml";

/// All steps, the short ones first. The tests of the workspace come last, so that their results end the output.
pub const STEPS: &[Step] = &[
    Step::cargo("fmt", &["fmt", "--all", "--check"]),
    Step::cargo("image-fmt", &["fmt", "--manifest-path", IMAGE, "--check"]),
    Step::cargo("modules", &["xtask", "modules"]),
    Step::cargo("clippy", &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]),
    Step {
        needs: &[Item::RustTargets],
        lints_image: true,
        ..Step::cargo(
            "image-clippy",
            &["clippy", "--manifest-path", IMAGE, "--target", CORTEX_M, "--features", "mps2", "--", "-D", "warnings"],
        )
    },
    Step { env: Some(("RUSTDOCFLAGS", "-D warnings")), ..Step::cargo("doc", &["doc", "--workspace", "--no-deps"]) },
    Step { needs: &[Item::Simlink], python: true, ..Step::cargo("simlink", &["-m", "simlink.tests"]) },
    Step { needs: &[Item::Simlink], python: true, ..Step::cargo("sitl", &["-m", "sitl.tests"]) },
    // Debug builds check for integer overflow, which must never occur in the on-board arithmetic.
    Step::cargo("core-debug", &["test", "--package", "firmware-core", "--no-fail-fast"]),
    Step { needs: targets::NEEDS, ..Step::cargo("targets", &["xtask", "targets"]) },
    // The C program is linked with the library that the step "targets" has built.
    Step {
        needs: &[Item::QemuArm, Item::ArmGcc],
        ..Step::cargo(
            "c-cortex-m",
            &["test", "--release", "--package", "covey-capi", "--test", "c_program", "--", "--ignored"],
        )
    },
    // Evaluates an actor in whole worlds on the flight program that the step "targets" has built.
    Step {
        needs: targets::NEEDS,
        ..Step::cargo(
            "pil",
            &["run", "--release", "--package", "host-trainer", "--", "eval", "--actor", "qemu-m7", "--worlds", "2"],
        )
    },
    Step { needs: counts::NEEDS, ..Step::cargo("counts", &["xtask", "counts"]) },
    Step {
        needs: &[Item::Browser, Item::PythonVenv, Item::Simlink],
        ..Step::cargo("tests", &["test", "--workspace", "--release", "--no-fail-fast"])
    },
];

impl Step {
    /// The command of the step.
    pub fn command(&self) -> Cmd {
        let program = if self.python { Cmd::new(simlink::python()) } else { Cmd::cargo() };
        let command = program.args(self.args);
        self.env.iter().fold(command, |command, (name, value)| command.env(name, value))
    }

    /// Runs the step with its output on this terminal, and adds the tests that it reports to `tally`.
    ///
    /// # Errors
    /// The command failed.
    pub fn run(&self, tally: &mut Tally) -> Result<()> {
        if self.lints_image && Toolchain::required()? == Toolchain::Linked {
            show!("left out: the targets' libraries are Debian's, which has no clippy for them");
            return Ok(());
        }
        self.command().run_watched(|line| tally.read(line))
    }
}
