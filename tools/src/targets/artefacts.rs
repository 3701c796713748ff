//! What is built: the node for computers, the images for boards, and actors to run on them.

use std::fs;
use std::path::{Path, PathBuf};

use firmware_core::hash::Fnv1a;

use super::work_folder;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::setup::rust_targets::{AARCH64, CORTEX_M, Toolchain};
use crate::workspace;

/// Actors of the default widths with made-up weights, one for each aggregation.
pub struct Actors {
    /// Plain PPO.
    pub none: PathBuf,
    /// Graph convolution.
    pub gcn: PathBuf,
    /// Graph attention.
    pub gat: PathBuf,
}

impl Actors {
    /// Writes them.
    ///
    /// # Errors
    /// The program that makes them cannot be built or run.
    pub fn make() -> Result<Self> {
        let folder = work_folder();
        fs::create_dir_all(&folder).map_err(Error::file(&folder))?;
        let make = |kind: &str| -> Result<PathBuf> {
            let file = folder.join(kind).with_extension("actor");
            let example = ["run", "--quiet", "--release", "--package", "firmware-core", "--example", "sample_actor"];
            Cmd::cargo().args(example).arg("--").arg(kind).arg(&file).read()?;
            Ok(file)
        };
        Ok(Self { none: make("none")?, gcn: make("gcn")?, gat: make("gat")? })
    }

    /// One number of the signatures of all three (FNV-1a, 64 bit, over their bytes in little-endian order).
    ///
    /// # Errors
    /// Those of `sign`.
    pub fn signature(&self, sign: impl Fn(&PathBuf) -> Result<u64>) -> Result<u64> {
        let mut hash = Fnv1a::new();
        for actor in [&self.none, &self.gcn, &self.gat] {
            hash.write(&sign(actor)?.to_le_bytes());
        }
        Ok(hash.finish())
    }
}

/// The node as it is built for computers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// This computer, without optimisation and with overflow checks.
    HostDebug,
    /// This computer.
    Host,
    /// A companion computer: a static executable.
    Aarch64,
}

impl Node {
    /// Every build.
    pub const ALL: [Self; 3] = [Self::HostDebug, Self::Host, Self::Aarch64];

    /// Name of the target in tables.
    pub const fn target(self) -> &'static str {
        match self {
            Self::HostDebug | Self::Host => "x86_64",
            Self::Aarch64 => "aarch64",
        }
    }

    /// Name of the profile in tables.
    pub const fn profile(self) -> &'static str {
        match self {
            Self::HostDebug => "debug",
            Self::Host | Self::Aarch64 => "release",
        }
    }

    /// Builds it and returns the executable.
    ///
    /// # Errors
    /// It cannot be built.
    pub fn build(self) -> Result<PathBuf> {
        let build = ["build", "--quiet", "--package", "sitl-bridge"];
        let target = workspace::target_folder();
        let folder = match self {
            Self::HostDebug => {
                Cmd::cargo().args(build).read()?;
                target.join("debug")
            }
            Self::Host => {
                Cmd::cargo().args(build).arg("--release").read()?;
                target.join("release")
            }
            Self::Aarch64 => {
                let cargo = Toolchain::required()?.cargo().args(build).args(["--release", "--target", AARCH64]);
                cargo
                    .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-gcc")
                    .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS", "-Ctarget-feature=+crt-static")
                    .read()?;
                target.join(AARCH64).join("release")
            }
        };
        Ok(folder.join("sitl-bridge"))
    }

    /// Lets the built `program` test an actor file.
    ///
    /// # Errors
    /// It refuses the file.
    pub fn self_test(self, program: &Path, actor: &Path) -> Result<()> {
        self.command(program).arg("self-test").arg(actor).read().map(drop)
    }

    fn command(self, program: &Path) -> Cmd {
        match self {
            Self::HostDebug | Self::Host => Cmd::new(program),
            Self::Aarch64 => Cmd::new(qemu_aarch64()).arg(program),
        }
    }

    /// The signature of an actor file by the built `program`.
    ///
    /// # Errors
    /// It fails, or prints something else.
    pub fn signature(self, program: &Path, actor: &Path) -> Result<u64> {
        let command = self.command(program).arg("signature").arg(actor);
        let printed = command.read()?;
        u64::from_str_radix(printed.trim(), 16).map_err(|_| Error::Output { command: command.to_string(), printed })
    }
}

fn qemu_aarch64() -> PathBuf {
    workspace::find_program(&["qemu-aarch64-static", "qemu-aarch64"]).unwrap_or_else(|| "qemu-aarch64-static".into())
}

/// A board that images are built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// QEMU's mps2-an500 and mps2-an386.
    Mps2,
    /// STM32H743 and STM32H753.
    Stm32h743,
}

impl Board {
    const fn feature(self) -> &'static str {
        match self {
            Self::Mps2 => "mps2",
            Self::Stm32h743 => "stm32h743",
        }
    }
}

/// The programs for a board.
pub struct Image {
    /// The program that flies.
    pub flight: PathBuf,
    /// The program that measures; QEMU only.
    pub measure: PathBuf,
}

impl Image {
    /// Builds them.
    ///
    /// # Errors
    /// They cannot be built. A program with a panic branch does not link.
    pub fn build(board: Board) -> Result<Self> {
        let target = work_folder().join(board.feature());
        Toolchain::required()?
            .cortex_m_cargo()
            .args(["build", "--quiet", "--release", "--target", CORTEX_M])
            .args(["--features", board.feature()])
            .arg("--target-dir")
            .arg(&target)
            .folder(workspace::root().join("firmware-core/image"))
            .read()?;
        let folder = target.join(CORTEX_M).join("release");
        Ok(Self { flight: folder.join("flight"), measure: folder.join("measure") })
    }
}

/// Builds the C interface's static library for Cortex-M as flight software links it; a test compiles a C program with it.
///
/// # Errors
/// It cannot be built.
pub fn c_library() -> Result<()> {
    Toolchain::required()?
        .cargo()
        .args(["rustc", "--quiet", "--package", "covey-capi", "--profile", "firmware", "--crate-type", "staticlib"])
        .args(["--target", CORTEX_M])
        .arg("--target-dir")
        .arg(work_folder().join("capi"))
        .read()?;
    Ok(())
}
