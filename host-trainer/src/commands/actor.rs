//! Actor files that the command line names.

use crate::eval::AnyActor;
use miette::{Result, WrapErr, miette};
use std::path::Path;

/// The actor file of a `--model`, or of an actor that comes with Covey: its bytes, and what to
/// call it.
pub fn read_actor(model: Option<&Path>) -> Result<(Vec<u8>, String)> {
    covey_env::open_actor(model).map_err(|e| unreadable(model.unwrap_or_else(|| Path::new("gcn")), &e))
}

/// A file's bytes.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| unreadable(path, &e))
}

/// The actor in a file of this name, after its self-test.
pub fn load<'a>(bytes: &'a [u8], name: &str) -> Result<AnyActor<'a>> {
    AnyActor::load_tested(bytes).map_err(|e| miette!("{e}")).wrap_err_with(|| format!("{name} cannot fly"))
}

fn unreadable(path: &Path, e: &std::io::Error) -> miette::Report {
    miette!("cannot read {}: {e}", path.display())
}
