//! The steps of the test run.

use super::tally::Tally;
use crate::command::Cmd;
use crate::counts;
use crate::error::Result;
use crate::setup::Item;
use crate::setup::rust_targets::{CORTEX_M, Toolchain};
use crate::setup::simlink;
use crate::targets;

/// One step: a command whose success is the check.
pub struct Step {
    /// The name on the command line and in the summary.
    pub name: &'static str,
    /// What must be installed before it runs.
    pub needs: &'static [Item],
    args: &'static [&'static str],
    env: Option<(&'static str, &'static str)>,
    /// The arguments are for the Python of the simulated autopilots instead of cargo.
    python: bool,
    /// It needs the Cortex-M library and lints: Debian's compiler has no clippy, there the step is left out.
    lints_image: bool,
}

impl Step {
    const fn cargo(name: &'static str, args: &'static [&'static str]) -> Self {
        Self { name, needs: &[], args, env: None, python: false, lints_image: false }
    }
}

const IMAGE: &str = "firmware-core/image/Cargo.toml";

/// All steps, cheap ones first; the long test run comes last so that its result closes the output.
pub const STEPS: &[Step] = &[
    Step::cargo("fmt", &["fmt", "--all", "--check"]),
    Step::cargo("image-fmt", &["fmt", "--manifest-path", IMAGE, "--check"]),
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
    // Debug builds check for integer overflow, which the on-board arithmetic promises never to do.
    Step::cargo("core-debug", &["test", "--package", "firmware-core", "--no-fail-fast"]),
    Step { needs: targets::NEEDS, ..Step::cargo("targets", &["xtask", "targets"]) },
    // The step before has built the library that the C program is linked with.
    Step {
        needs: &[Item::QemuArm, Item::ArmGcc],
        ..Step::cargo(
            "c-cortex-m",
            &["test", "--release", "--package", "covey-capi", "--test", "c_program", "--", "--ignored"],
        )
    },
    // The flight program that "targets" has built flies whole worlds.
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
    /// What the step runs.
    pub fn command(&self) -> Cmd {
        let program = if self.python { Cmd::new(simlink::python()) } else { Cmd::cargo() };
        let command = program.args(self.args);
        self.env.iter().fold(command, |command, (name, value)| command.env(name, value))
    }

    /// Runs it on this terminal, counting the tests that it reports.
    ///
    /// # Errors
    /// The command ended badly.
    pub fn run(&self, tally: &mut Tally) -> Result<()> {
        if self.lints_image && Toolchain::required()? == Toolchain::Linked {
            println!("left out: the targets' libraries are Debian's, which has no clippy for them");
            return Ok(());
        }
        self.command().run_watched(|line| tally.read(line))
    }
}
