//! The things that set-up knows to look for and to install.

use clap::ValueEnum;

use crate::command::Cmd;
use crate::workspace::find_program;

/// One thing the tests or the target builds need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Item {
    /// A Chromium browser: the report's pages are opened in it.
    Browser,
    /// Python's venv and pip: the simulated autopilots run in one.
    PythonVenv,
}

impl Item {
    /// All items, in the order of their set-up.
    pub const ALL: &[Self] = &[Self::Browser, Self::PythonVenv];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Browser => "browser",
            Self::PythonVenv => "python-venv",
        }
    }

    /// What it is for, in a few words.
    pub const fn purpose(self) -> &'static str {
        match self {
            Self::Browser => "Chromium, opens the reports in tests",
            Self::PythonVenv => "Python with venv and pip, runs the simulated autopilots",
        }
    }

    /// The Debian packages that hold it.
    pub const fn packages(self) -> &'static [&'static str] {
        match self {
            Self::Browser => &["chromium"],
            Self::PythonVenv => &["python3", "python3-venv"],
        }
    }

    /// Whether it is there and works.
    pub fn is_present(self) -> bool {
        match self {
            Self::Browser => find_program(&["chromium", "chromium-browser", "google-chrome"]).is_some(),
            Self::PythonVenv => Cmd::new("python3").args(["-c", "import venv, ensurepip"]).succeeds(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_knows_each_item_by_its_name() {
        assert_eq!(Item::ALL.len(), Item::value_variants().len());
        for &item in Item::ALL {
            assert_eq!(Item::from_str(item.name(), false), Ok(item));
        }
    }
}
