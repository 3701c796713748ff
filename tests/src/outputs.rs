//! Outputs that break.

use std::fs::OpenOptions;
use std::io::Read as _;
use std::process::{Command, Output, Stdio};

/// Where a program's outputs go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outputs {
    /// Somebody reads both.
    Read,
    /// Standard output takes nothing: its disk is full.
    FullOut,
    /// Standard error takes nothing.
    FullErr,
    /// Nobody reads standard output.
    CutOut,
    /// Nobody reads standard error.
    CutErr,
    /// The reader of standard output goes after the first byte.
    CutInTheMiddle,
    /// Both were closed before the program began.
    Closed,
}

impl Outputs {
    /// All that break.
    pub const BROKEN: [Self; 6] =
        [Self::FullOut, Self::FullErr, Self::CutOut, Self::CutErr, Self::CutInTheMiddle, Self::Closed];

    /// Runs a command to its end.
    pub(crate) fn run(self, command: &mut Command) -> std::io::Result<Output> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        match self {
            Self::Read => {}
            Self::FullOut => _ = command.stdout(full()),
            Self::FullErr => _ = command.stderr(full()),
            Self::CutOut => _ = command.stdout(cut()?),
            Self::CutErr => _ = command.stderr(cut()?),
            Self::CutInTheMiddle => {
                let mut child = command.spawn()?;
                if let Some(mut out) = child.stdout.take() {
                    // A program that says nothing ends it too.
                    let _ = out.read(&mut [0])?;
                }
                return child.wait_with_output();
            }
            Self::Closed => {
                let mut shell = Command::new("/bin/sh");
                shell.args(["-c", r#"exec "$0" "$@" >&- 2>&-"#]).arg(command.get_program()).args(command.get_args());
                shell.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
                if let Some(folder) = command.get_current_dir() {
                    shell.current_dir(folder);
                }
                return shell.stdin(Stdio::null()).output();
            }
        }
        command.output()
    }
}

fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").expect("a device of Linux").into()
}

/// A pipe that nobody reads any more.
fn cut() -> std::io::Result<Stdio> {
    let (reader, writer) = std::io::pipe()?;
    drop(reader);
    Ok(writer.into())
}
