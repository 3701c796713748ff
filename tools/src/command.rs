//! Running other programs.

use std::ffi::OsStr;
use std::fmt;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use crate::error::{Error, Result};
use crate::workspace;

/// A command line of another program. It runs in the workspace root unless another folder is set, and is displayed as
/// it would be typed in a shell.
#[derive(Clone, Debug)]
pub struct Cmd {
    program: String,
    args: Vec<String>,
    env: Vec<(String, String)>,
    folder: PathBuf,
}

impl Cmd {
    /// A command that runs `program`, a name on the search path or a path, without arguments.
    pub fn new(program: impl AsRef<OsStr>) -> Self {
        Self {
            program: program.as_ref().to_string_lossy().into_owned(),
            args: Vec::new(),
            env: Vec::new(),
            folder: workspace::root(),
        }
    }

    /// A command that runs cargo, of the toolchain that also runs `cargo xtask`.
    pub fn cargo() -> Self {
        Self::new("cargo")
    }

    /// Adds arguments.
    #[must_use]
    pub fn args<S: AsRef<OsStr>>(mut self, args: impl IntoIterator<Item = S>) -> Self {
        self.args.extend(args.into_iter().map(|arg| arg.as_ref().to_string_lossy().into_owned()));
        self
    }

    /// Adds one argument.
    #[must_use]
    pub fn arg(self, arg: impl AsRef<OsStr>) -> Self {
        self.args([arg])
    }

    /// Sets an environment variable.
    #[must_use]
    pub fn env(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.env.push((name.into(), value.as_ref().to_string_lossy().into_owned()));
        self
    }

    /// Runs the program in `folder`.
    #[must_use]
    pub fn folder(mut self, folder: impl AsRef<Path>) -> Self {
        self.folder = folder.as_ref().into();
        self
    }

    /// The same command run as root by sudo.
    #[must_use]
    pub fn into_root(mut self) -> Self {
        // sudo clears the environment, so env sets the variables again.
        let mut args = vec!["env".to_owned()];
        args.extend(self.env.drain(..).map(|(name, value)| format!("{name}={value}")));
        args.push(std::mem::replace(&mut self.program, "sudo".into()));
        args.append(&mut self.args);
        self.args = args;
        self
    }

    /// The same command with a time limit in seconds, after which it is stopped and counts as failed.
    #[must_use]
    pub fn within(mut self, seconds: u32) -> Self {
        let program = std::mem::replace(&mut self.program, "timeout".into());
        self.args.splice(..0, [seconds.to_string(), program]);
        self
    }

    fn build(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.args).current_dir(&self.folder).stdin(Stdio::null());
        command.envs(self.env.iter().map(|(name, value)| (name, value)));
        command
    }

    /// Runs the command without printing anything and returns its standard output.
    ///
    /// # Errors
    /// The program cannot be started, or fails; then the error has its error output.
    pub fn read(&self) -> Result<String> {
        let output = self.build().output().map_err(self.start_error())?;
        self.check(output.status, &String::from_utf8_lossy(&output.stderr))?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Runs the command without printing anything and returns its standard output followed by its error output.
    ///
    /// # Errors
    /// The program cannot be started, or fails; then the error has both outputs.
    pub fn read_all(&self) -> Result<String> {
        let output = self.build().output().map_err(self.start_error())?;
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8_lossy(&text).into_owned();
        self.check(output.status, &text)?;
        Ok(text)
    }

    /// Runs the command without printing anything and returns whether it succeeded.
    pub fn succeeds(&self) -> bool {
        self.build().output().is_ok_and(|output| output.status.success())
    }

    /// Runs the command with its output on this terminal, and also calls `look` with each line of its standard
    /// output.
    ///
    /// # Errors
    /// The program cannot be started, or fails.
    pub fn run_watched(&self, mut look: impl FnMut(&str)) -> Result<()> {
        let mut child = self.build().stdout(Stdio::piped()).spawn().map_err(self.start_error())?;
        if let Some(stdout) = child.stdout.take() {
            let mut terminal = std::io::stdout().lock();
            // Tests may print any bytes, so lines are not assumed to be UTF-8.
            for line in BufReader::new(stdout).split(b'\n').map_while(std::result::Result::ok) {
                look(&String::from_utf8_lossy(&line));
                // Errors are ignored: a closed terminal must not stop the tests.
                let _ = terminal.write_all(&line).and_then(|()| terminal.write_all(b"\n"));
                let _ = terminal.flush();
            }
        }
        let status = child.wait().map_err(self.start_error())?;
        self.check(status, "")
    }

    fn start_error(&self) -> impl FnOnce(std::io::Error) -> Error {
        let command = self.to_string();
        move |source| Error::Start { command, source }
    }

    fn check(&self, status: ExitStatus, stderr: &str) -> Result<()> {
        if status.success() {
            return Ok(());
        }
        let output = if stderr.trim().is_empty() { String::new() } else { format!("\n{}", stderr.trim_end()) };
        Err(Error::Failed { command: self.to_string(), status: status.to_string(), output })
    }
}

impl fmt::Display for Cmd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.env {
            write!(f, "{name}={} ", quoted(value))?;
        }
        f.write_str(&quoted(&self.program))?;
        for arg in &self.args {
            write!(f, " {}", quoted(arg))?;
        }
        Ok(())
    }
}

/// Quotes `text` for a POSIX shell if it needs quotes.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.into() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_prints_as_one_would_type_it() {
        let command = Cmd::new("tool").args(["--name", "two words", "it's"]).env("FLAGS", "-D warnings");
        assert_eq!(command.to_string(), r"FLAGS='-D warnings' tool --name 'two words' 'it'\''s'");
    }

    #[test]
    fn a_command_as_root_keeps_its_variables() {
        let command = Cmd::new("tool").arg("x").env("A", "1").into_root();
        assert_eq!(command.to_string(), "sudo env A=1 tool x");
    }

    #[test]
    fn watched_lines_are_those_of_the_standard_output() {
        let mut lines = Vec::new();
        let done =
            Cmd::new("sh").args(["-c", "echo one; echo two; exit 3"]).run_watched(|line| lines.push(line.to_owned()));
        assert_eq!(lines, ["one", "two"]);
        assert!(matches!(done, Err(Error::Failed { .. })));
    }
}
