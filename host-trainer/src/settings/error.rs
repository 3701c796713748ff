//! Why settings were refused.

use thiserror::Error;

/// Why settings were refused: what is wrong and what would be right.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// The settings file cannot be read.
    #[error("cannot read the settings file {path}")]
    Read {
        /// The file.
        path: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{path} is not valid TOML: {message}")]
    Syntax {
        /// The file.
        path: String,
        /// Line, column and reason.
        message: String,
    },
    /// There is no setting of this name, neither today nor formerly.
    #[error("there is no setting `{key}`; the nearest is `{nearest}`; `host-trainer settings` lists them all")]
    UnknownKey {
        /// The name given.
        key: String,
        /// The name most like it.
        nearest: &'static str,
    },
    /// A setting is given by its old name and by its new one.
    #[error("`{old}` is the old name of `{new}`, and both are given; keep `{new}` alone")]
    BothNames {
        /// The old name.
        old: &'static str,
        /// Today's name.
        new: &'static str,
    },
    /// The value is of another type.
    #[error("setting `{key}` wants {wanted}, not {found}")]
    Type {
        /// The setting.
        key: &'static str,
        /// The type it has, in words.
        wanted: String,
        /// The value given, as TOML.
        found: String,
    },
    /// The value is out of bounds.
    #[error("setting `{key}` is {found}; it must be {allowed}")]
    Range {
        /// The setting.
        key: &'static str,
        /// The value given.
        found: String,
        /// The bounds, in words.
        allowed: String,
    },
    /// An error in a file.
    #[error("{path}: {error}")]
    In {
        /// The file.
        path: String,
        /// What is wrong in it.
        error: Box<Self>,
    },
    /// `--set` was given a text without `=`.
    #[error("`--set {0}` has no value; write `--set key=value`")]
    NoValue(String),
    /// Each value is within its bounds, but they do not go together.
    #[error("{0}")]
    Together(String),
}
