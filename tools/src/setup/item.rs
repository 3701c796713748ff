//! The things that `cargo xtask setup` can find and install.

use clap::ValueEnum;

use super::rust_targets::Toolchain;
use super::simlink;
use crate::command::Cmd;
use crate::workspace::find_program;

/// Something that the tests or the target builds need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Item {
    /// A Chromium browser: the report's pages are opened in it.
    Browser,
    /// Python's venv and pip: the simulated autopilots run in one.
    PythonVenv,
    /// The simulated autopilots' own Python environment.
    Simlink,
    /// QEMU's Cortex-M machines: the bare-metal images are run on them.
    QemuArm,
    /// QEMU for single aarch64 programs: the companion computer's node is run in it.
    QemuAarch64,
    /// A C compiler and a static C library for aarch64: they link the node.
    Aarch64Gcc,
    /// A C compiler and library for Cortex-M: flight software in C is compiled with one.
    ArmGcc,
    /// Rust's libraries for Cortex-M and aarch64 Linux.
    RustTargets,
    /// Valgrind, which counts the instructions of the trainer's parts.
    Valgrind,
}

impl Item {
    /// All items, in the order of their set-up.
    pub const ALL: &[Self] = &[
        Self::Browser,
        Self::PythonVenv,
        Self::Simlink,
        Self::QemuArm,
        Self::QemuAarch64,
        Self::Aarch64Gcc,
        Self::ArmGcc,
        Self::RustTargets,
        Self::Valgrind,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Browser => "browser",
            Self::PythonVenv => "python-venv",
            Self::Simlink => "simlink",
            Self::QemuArm => "qemu-arm",
            Self::QemuAarch64 => "qemu-aarch64",
            Self::Aarch64Gcc => "aarch64-gcc",
            Self::ArmGcc => "arm-gcc",
            Self::RustTargets => "rust-targets",
            Self::Valgrind => "valgrind",
        }
    }

    /// What it is for, in a few words.
    pub const fn purpose(self) -> &'static str {
        match self {
            Self::Browser => "Chromium, opens the reports in tests",
            Self::PythonVenv => "Python with venv and pip, runs the simulated autopilots",
            Self::Simlink => "pymavlink in .venv, the simulated autopilots speak with it",
            Self::QemuArm => "QEMU for Cortex-M boards, runs the bare-metal images",
            Self::QemuAarch64 => "QEMU for aarch64 programs, runs the companion computer's node",
            Self::Aarch64Gcc => "C compiler and static C library for aarch64, link the node",
            Self::ArmGcc => "C compiler and library for Cortex-M, compile a C program against the C interface",
            Self::RustTargets => "Rust's libraries for Cortex-M and aarch64 Linux",
            Self::Valgrind => "counts instructions of the trainer's parts",
        }
    }

    /// The Debian packages that contain it; empty for what is installed in another way.
    pub const fn packages(self) -> &'static [&'static str] {
        match self {
            Self::Browser => &["chromium"],
            Self::PythonVenv => &["python3", "python3-venv"],
            Self::QemuArm => &["qemu-system-arm"],
            Self::QemuAarch64 => &["qemu-user-static"],
            Self::Aarch64Gcc => &["gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross"],
            Self::ArmGcc => &["gcc-arm-none-eabi", "picolibc-arm-none-eabi"],
            Self::Valgrind => &["valgrind"],
            Self::Simlink | Self::RustTargets => &[],
        }
    }

    /// Whether it is installed and works.
    pub fn is_present(self) -> bool {
        match self {
            Self::Browser => find_program(&["chromium", "chromium-browser", "google-chrome"]).is_some(),
            Self::PythonVenv => Cmd::new("python3").args(["-c", "import venv, ensurepip"]).succeeds(),
            Self::Simlink => simlink::is_present(),
            Self::QemuArm => find_program(&["qemu-system-arm"]).is_some(),
            Self::QemuAarch64 => find_program(&["qemu-aarch64-static", "qemu-aarch64"]).is_some(),
            Self::Aarch64Gcc => compiler_has("aarch64-linux-gnu-gcc", "libc.a"),
            Self::ArmGcc => compiler_has("arm-none-eabi-gcc", "picolibc.specs"),
            Self::RustTargets => Toolchain::find().is_some(),
            Self::Valgrind => find_program(&["valgrind"]).is_some(),
        }
    }
}

/// Whether this C compiler is installed and has this library file.
fn compiler_has(compiler: &str, file: &str) -> bool {
    // For a file that it does not have, the compiler prints the name without a folder.
    Cmd::new(compiler).arg(format!("-print-file-name={file}")).read().is_ok_and(|path| path.trim().starts_with('/'))
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
