//! What is wrong in a file, before its name is known.

/// A field and what is wrong with it.
#[derive(Debug)]
pub(super) struct Fault {
    /// Empty where it is the form of the whole file.
    pub field: String,
    pub problem: String,
}

pub(super) fn fault(field: &str, problem: impl std::fmt::Display) -> Fault {
    Fault { field: field.to_owned(), problem: format!("{field} {problem}") }
}

/// The file as a whole is wrong.
pub(super) fn broken(message: impl Into<String>) -> Fault {
    Fault { field: String::new(), problem: message.into() }
}
