//! `self-test` and `signature`: does this computer compute what the actor's exporter computed?

use super::output::print;
use firmware_core::actor::{self, Actor, FINGERPRINT_CASES, LoadError, SELF_TESTS, SelfTestError};
use miette::IntoDiagnostic as _;
use std::path::{Path, PathBuf};
use std::{fs, io};
use thiserror::Error;

/// Why an actor file must not fly on this computer.
#[derive(Debug, Error)]
pub(crate) enum ActorFileError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// It is damaged or no actor file.
    #[error("{} is no actor file that can fly", path.display())]
    Load {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: LoadError,
    },
    /// This computer computes other logits: the self-test failed.
    #[error("{} must not fly here", path.display())]
    SelfTest {
        /// The file.
        path: PathBuf,
        /// Which vector differs.
        source: SelfTestError,
    },
}

/// Arguments of `self-test`.
#[derive(clap::Args)]
pub(crate) struct SelfTest {
    /// The actor file.
    file: PathBuf,
}

impl SelfTest {
    /// Runs the self-test and prints one line when it passes.
    ///
    /// # Errors
    /// See [`ActorFileError`]; or standard output takes nothing.
    pub fn run(self) -> miette::Result<()> {
        let line =
            with_actor(self.file, |actor| format!("{SELF_TESTS} vectors hold, actor {:016x}\n", actor.content_hash()));
        print(&line.into_diagnostic()?)
    }
}

/// Arguments of `signature`.
#[derive(clap::Args)]
pub(crate) struct Signature {
    /// The actor file.
    file: PathBuf,
    /// Number of neighbourhoods to decide.
    #[arg(long, default_value_t = FINGERPRINT_CASES)]
    cases: u32,
}

impl Signature {
    /// Prints the signature, 16 hexadecimal digits.
    ///
    /// # Errors
    /// See [`ActorFileError`]; the self-test comes first. Or standard output takes nothing.
    pub fn run(self) -> miette::Result<()> {
        let line = with_actor(self.file, |actor| format!("{:016x}\n", actor::fingerprint(actor, self.cases)));
        print(&line.into_diagnostic()?)
    }
}

/// Calls `action` with the actor of the file, which has passed its self-test.
fn with_actor<T>(path: PathBuf, action: impl FnOnce(&Actor<'_>) -> T) -> Result<T, ActorFileError> {
    let bytes = read(&path)?;
    Ok(action(&flight_ready(&bytes, &path)?))
}

/// The bytes of an actor file.
///
/// # Errors
/// [`ActorFileError::Read`].
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, ActorFileError> {
    fs::read(path).map_err(|source| ActorFileError::Read { path: path.to_owned(), source })
}

/// The actor in these bytes, once it has passed its self-test on this computer. `path` is for
/// error messages.
///
/// # Errors
/// [`ActorFileError::Load`] or [`ActorFileError::SelfTest`]: it never flies.
pub(crate) fn flight_ready<'a>(bytes: &'a [u8], path: &Path) -> Result<Actor<'a>, ActorFileError> {
    let actor = Actor::load(bytes).map_err(|source| ActorFileError::Load { path: path.to_owned(), source })?;
    match actor.self_test() {
        Ok(()) => Ok(actor),
        Err(source) => Err(ActorFileError::SelfTest { path: path.to_owned(), source }),
    }
}
