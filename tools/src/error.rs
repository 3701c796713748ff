//! The errors of `cargo xtask`. Each message says what was wrong and what to do next.

use std::io;
use std::path::{Path, PathBuf};

use crate::flash::FlashError;

/// The result of a task.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a task did not succeed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A program could not be started.
    #[error("cannot start `{command}`: {source}")]
    Start {
        /// The whole command, as one would type it.
        command: String,
        /// The operating system's reason.
        source: io::Error,
    },
    /// A program ended with a failure.
    #[error("failed ({status}): {command}{output}")]
    Failed {
        /// The whole command, as one would type it.
        command: String,
        /// Its exit status.
        status: String,
        /// Its captured error output with a leading line break, or nothing where it went to the terminal.
        output: String,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// Packages are missing and only root may install them.
    #[error("installing packages needs root and sudo would ask for a password; run this, then try again:\n  {command}")]
    NeedsRoot {
        /// The command that the user should run.
        command: String,
    },
    /// The computer has no apt-get.
    #[error(
        "this machine has no apt-get; install what these Debian packages hold with its own package manager, then try again:\n  {packages}"
    )]
    NotDebian {
        /// The Debian packages, separated by spaces.
        packages: String,
    },
    /// `setup --check` found something missing.
    #[error("missing: {names}; `cargo xtask setup` installs it")]
    Missing {
        /// Names of the missing items.
        names: String,
    },
    /// A name on the command line is unknown.
    #[error("there is no {kind} `{name}`; known: {known}")]
    Unknown {
        /// What the name should be of, such as `step`.
        kind: &'static str,
        /// The name as given.
        name: String,
        /// All valid names.
        known: String,
    },
    /// Something was installed but still does not work; the text says what.
    #[error("{0}")]
    Setup(String),
    /// An emulated board did not do what it should; the text says what it did.
    #[error("{0}")]
    Board(String),
    /// The task's result cannot be printed.
    #[error("cannot write to standard output: {0}; send it elsewhere to see the result")]
    Print(io::Error),
    /// The output of a program could not be understood.
    #[error("{command}\nprinted something that was not expected here:\n{printed}")]
    Output {
        /// The whole command, as one would type it.
        command: String,
        /// What it printed.
        printed: String,
    },
    /// A file that can be read does not hold what it should.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        what: String,
    },
    /// Circles of source files, and dependencies between crates that are not in the document, one a line.
    #[error("dependencies that should not be:\n{0}")]
    Modules(String),
    /// Measured figures that are not what they should be, one a line.
    #[error("figures that are not what they should be:\n{0}")]
    Figures(String),
    /// The PIL protocol failed.
    #[error("processor in the loop: {0}")]
    Pil(#[from] covey_pil::PilError),
    /// Flashing failed.
    #[error(transparent)]
    Flash(#[from] FlashError),
    /// The emulated board does not run.
    #[error(transparent)]
    Qemu(#[from] covey_pil::qemu::QemuError),
    /// A failure that has been reported on the terminal already.
    #[error("failed, see above")]
    Reported,
}

impl Error {
    /// Says what is wrong with the content of a file.
    pub fn content(path: &Path, what: String) -> Self {
        Self::Content { path: path.into(), what }
    }

    /// Wraps an I/O error with the file it is about.
    pub fn file(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
