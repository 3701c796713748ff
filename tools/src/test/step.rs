//! The steps of the test run.

use super::tally::Tally;
use crate::command::Cmd;
use crate::error::Result;
use crate::setup::Item;

/// One step: a command whose success is the check.
pub struct Step {
    /// The name on the command line and in the summary.
    pub name: &'static str,
    /// What must be installed before it runs.
    pub needs: &'static [Item],
    args: &'static [&'static str],
    env: Option<(&'static str, &'static str)>,
}

/// All steps, cheap ones first; the long test run comes last so that its result closes the output.
pub const STEPS: &[Step] = &[
    Step { name: "fmt", needs: &[], args: &["fmt", "--all", "--check"], env: None },
    Step {
        name: "clippy",
        needs: &[],
        args: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
        env: None,
    },
    Step {
        name: "doc",
        needs: &[],
        args: &["doc", "--workspace", "--no-deps"],
        env: Some(("RUSTDOCFLAGS", "-D warnings")),
    },
    // Debug builds check for integer overflow, which the on-board arithmetic promises never to do.
    Step { name: "core-debug", needs: &[], args: &["test", "--package", "firmware-core", "--no-fail-fast"], env: None },
    Step {
        name: "tests",
        needs: &[Item::Browser, Item::PythonVenv],
        args: &["test", "--workspace", "--release", "--no-fail-fast"],
        env: None,
    },
];

impl Step {
    /// What the step runs.
    pub fn command(&self) -> Cmd {
        let command = Cmd::cargo().args(self.args);
        self.env.iter().fold(command, |command, (name, value)| command.env(name, value))
    }

    /// Runs it on this terminal, counting the tests that it reports.
    ///
    /// # Errors
    /// The command ended badly.
    pub fn run(&self, tally: &mut Tally) -> Result<()> {
        self.command().run_watched(|line| tally.read(line))
    }
}
