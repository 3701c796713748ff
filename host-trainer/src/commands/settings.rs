//! `settings`, and the settings that other commands are given.

use crate::commands::output::tell;
use crate::settings::{Renamed, Settings, keys};
use miette::{IntoDiagnostic, Result};

/// Every setting with its meaning, bounds and default: a settings file.
pub fn page() -> String {
    let mut out = String::from("# Settings of a training run with their defaults. Use with train --config.\n\n");
    for key in keys() {
        for line in &key.doc {
            out += &format!("# {line}\n");
        }
        out += &format!("# {}\n{} = {}\n\n", key.bounds, key.name, key.default);
    }
    out
}

/// Applies every `--set` to settings and validates them.
pub fn apply(settings: &mut Settings, assignments: &[String]) -> Result<()> {
    for assignment in assignments {
        warn(settings.set(assignment).into_diagnostic()?);
    }
    settings.validate().into_diagnostic()
}

/// Says on the error output which settings have another name now.
pub fn warn(renamed: impl IntoIterator<Item = Renamed>) {
    renamed.into_iter().for_each(|renamed| tell!("{renamed}"));
}
