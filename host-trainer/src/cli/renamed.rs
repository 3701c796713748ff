//! Flags and commands that had another name: what was typed before still works.

use std::ffi::{OsStr, OsString};
use std::fmt;

/// A flag, or the name of a command, that was given by its old name. Shown, it says what to write
/// instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RenamedFlag {
    /// The command that takes it.
    command: &'static str,
    old: &'static str,
    new: &'static str,
}

const RENAMED: [RenamedFlag; 4] = [
    RenamedFlag { command: "eval", old: "--link", new: "--radio" },
    RenamedFlag { command: "eval", old: "--scenario", new: "--poi-distribution" },
    RenamedFlag { command: "experiment", old: "link", new: "radio" },
    RenamedFlag { command: "experiment", old: "--scenario", new: "--poi-distribution" },
];

impl fmt::Display for RenamedFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{} {}` is now `{0} {}`", self.command, self.old, self.new)
    }
}

/// The program's arguments, the program's own name first, with today's names in place of old ones,
/// and what was replaced.
#[must_use]
pub fn with_current_names(arguments: impl IntoIterator<Item = OsString>) -> (Vec<OsString>, Vec<RenamedFlag>) {
    let mut arguments: Vec<OsString> = arguments.into_iter().collect();
    let command = arguments.get(1).cloned().unwrap_or_default();
    let mut replaced = Vec::new();
    for (place, argument) in arguments.iter_mut().enumerate().skip(2) {
        for entry in RENAMED.into_iter().filter(|entry| command == OsStr::new(entry.command)) {
            // The name of a command stands right behind `experiment`; anywhere else it is a value.
            let is_flag = entry.old.starts_with("--");
            let Some(text) = argument.to_str().filter(|_| is_flag || place == 2) else { continue };
            let Some(value) = text.strip_prefix(entry.old).filter(|v| v.is_empty() || is_flag && v.starts_with('='))
            else {
                continue;
            };
            *argument = format!("{}{value}", entry.new).into();
            if !replaced.contains(&entry) {
                replaced.push(entry);
            }
            break;
        }
    }
    (arguments, replaced)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_names_become_todays_where_they_were_names() {
        let with = |text: &str| {
            let (arguments, replaced) = with_current_names(text.split(' ').map(OsString::from));
            (arguments.join(OsStr::new(" ")).into_string().unwrap(), replaced.len())
        };
        assert_eq!(
            with("p eval --link loss=0.1 --link=loss=0.3"),
            ("p eval --radio loss=0.1 --radio=loss=0.3".into(), 1)
        );
        assert_eq!(
            with("p experiment link --scenario uniform"),
            ("p experiment radio --poi-distribution uniform".into(), 2)
        );
        for same in ["p", "p train --out link", "p eval --links x", "p experiment paper --out link", "p bench --link"] {
            assert_eq!(with(same), (same.to_owned(), 0));
        }
    }
}
