//! Why a mission is refused.

use super::format::Format;
use super::text::TextError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a mission was refused.
#[derive(Debug, Error)]
pub enum MissionError {
    /// The file cannot be read.
    #[error("cannot read the mission {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// The file is no text in UTF-8.
    #[error("mission {} {problem}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        problem: TextError,
    },
    /// It is none of the formats that missions have.
    #[error("mission {}: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What it is, and what to do.
        message: String,
    },
    /// The file breaks the rules of its format, lacks a field, has one too many or one of another type.
    #[error("mission {}{}: {message}", path.display(), doubt(*format, *by_name))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What its content is.
        format: Format,
        /// What its name says, where that is something else.
        by_name: Option<Format>,
        /// Where and what.
        message: String,
    },
    /// A value that cannot be flown.
    #[error(
        "mission {}{}{}: {problem}",
        path.display(),
        line.map(|n| format!(", line {n}")).unwrap_or_default(),
        doubt(*format, *by_name)
    )]
    Value {
        /// The file.
        path: PathBuf,
        /// What its content is.
        format: Format,
        /// What its name says, where that is something else.
        by_name: Option<Format>,
        /// The line, where the form of the file tells it.
        line: Option<usize>,
        /// The field.
        field: String,
        /// What is wrong with it and what would be right.
        problem: String,
    },
}

/// Both formats, where content and name disagree.
fn doubt(format: Format, by_name: Option<Format>) -> String {
    by_name.map(|name| format!(" (its content is {format}, its name says {name})")).unwrap_or_default()
}
