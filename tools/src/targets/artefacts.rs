//! Building the node for computers, the images for boards, and actor files to run on them.

use std::fs;
use std::path::{Path, PathBuf};

use firmware_core::hash::Fnv1a;

use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::setup::rust_targets::{AARCH64, CORTEX_M, Toolchain};
use crate::workspace::{self, targets_folder};

/// Actor files with the default layer widths and made-up weights, one for each aggregation.
pub struct Actors {
    /// No aggregation: plain PPO.
    pub none: PathBuf,
    /// Graph convolution.
    pub gcn: PathBuf,
    /// Graph attention.
    pub gat: PathBuf,
    /// Graph attention in the form of Brody et al.
    pub gatv2: PathBuf,
    /// Mean of the neighbours.
    pub sage: PathBuf,
}

impl Actors {
    /// Writes the files.
    ///
    /// # Errors
    /// The example program that makes them cannot be built or run.
    pub fn make() -> Result<Self> {
        let folder = targets_folder();
        fs::create_dir_all(&folder).map_err(Error::file(&folder))?;
        let make = |kind: &str| -> Result<PathBuf> {
            let file = folder.join(kind).with_extension("actor");
            let example = ["run", "--quiet", "--release", "--package", "firmware-core", "--example", "sample_actor"];
            Cmd::cargo().args(example).arg("--").arg(kind).arg(&file).read()?;
            Ok(file)
        };
        Ok(Self {
            none: make("none")?,
            gcn: make("gcn")?,
            gat: make("gat")?,
            gatv2: make("gatv2")?,
            sage: make("sage")?,
        })
    }

    /// All of them, in a fixed order.
    pub const fn all(&self) -> [&PathBuf; 5] {
        [&self.none, &self.gcn, &self.gat, &self.gatv2, &self.sage]
    }

    /// Computes the signature of each file with `sign` and combines them into one number (64-bit FNV-1a hash
    /// over their little-endian bytes).
    ///
    /// # Errors
    /// The errors of `sign`.
    pub fn signature(&self, sign: impl Fn(&PathBuf) -> Result<u64>) -> Result<u64> {
        let mut hash = Fnv1a::new();
        for actor in self.all() {
            hash.write(&sign(actor)?.to_le_bytes());
        }
        Ok(hash.finish())
    }
}

/// A build of the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// For this computer, without optimisation and with overflow checks.
    HostDebug,
    /// For this computer, optimised.
    Host,
    /// For a companion computer, optimised and statically linked.
    Aarch64,
}

impl Node {
    /// All builds.
    pub const ALL: [Self; 3] = [Self::HostDebug, Self::Host, Self::Aarch64];

    /// The name of the target in tables.
    pub const fn target(self) -> &'static str {
        match self {
            Self::HostDebug | Self::Host => "x86_64",
            Self::Aarch64 => "aarch64",
        }
    }

    /// The name of the build profile in tables.
    pub const fn profile(self) -> &'static str {
        match self {
            Self::HostDebug => "debug",
            Self::Host | Self::Aarch64 => "release",
        }
    }

    /// Builds the node and returns the path of the executable.
    ///
    /// # Errors
    /// The build failed.
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

    /// Runs the actor file's self-test with the built `program`.
    ///
    /// # Errors
    /// The program refuses the file.
    pub fn self_test(self, program: &Path, actor: &Path) -> Result<()> {
        self.command(program).arg("self-test").arg(actor).read().map(drop)
    }

    /// A command that runs the built `program`, in QEMU where it is for another processor.
    fn command(self, program: &Path) -> Cmd {
        match self {
            Self::HostDebug | Self::Host => Cmd::new(program),
            Self::Aarch64 => Cmd::new(qemu_aarch64()).arg(program),
        }
    }

    /// Computes the signature of an actor file with the built `program`.
    ///
    /// # Errors
    /// The program fails, or prints something else.
    pub fn signature(self, program: &Path, actor: &Path) -> Result<u64> {
        let command = self.command(program).arg("signature").arg(actor);
        let printed = command.read()?;
        u64::from_str_radix(printed.trim(), 16).map_err(|_| Error::Output { command: command.to_string(), printed })
    }
}

/// The QEMU that runs aarch64 programs.
fn qemu_aarch64() -> PathBuf {
    workspace::find_program(&["qemu-aarch64-static", "qemu-aarch64"]).unwrap_or_else(|| "qemu-aarch64-static".into())
}

/// A board that images are built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// QEMU's mps2-an500 (Cortex-M7) and mps2-an386 (Cortex-M4F), which run the same image.
    Mps2,
    /// Boards with an STM32H743 or STM32H753.
    Stm32h743,
}

impl Board {
    /// The cargo feature that chooses the board.
    const fn feature(self) -> &'static str {
        match self {
            Self::Mps2 => "mps2",
            Self::Stm32h743 => "stm32h743",
        }
    }
}

/// The programs for a board: paths of the executables.
pub struct Image {
    /// The flight program: it serves the PIL protocol.
    pub flight: PathBuf,
    /// The measuring program; for QEMU's boards only.
    pub measure: PathBuf,
}

impl Image {
    /// Builds the programs.
    ///
    /// # Errors
    /// The build failed, for example because a program has a panic branch: then it does not link.
    pub fn build(board: Board) -> Result<Self> {
        let target = targets_folder().join(board.feature());
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

/// Builds the static library of the C interface for Cortex-M, in the form that flight software links. A test compiles
/// a C program against it.
///
/// # Errors
/// The build failed.
pub fn c_library() -> Result<()> {
    Toolchain::required()?
        .cargo()
        .args(["rustc", "--quiet", "--package", "covey-capi", "--profile", "firmware", "--crate-type", "staticlib"])
        .args(["--target", CORTEX_M])
        .arg("--target-dir")
        .arg(targets_folder().join("capi"))
        .read()?;
    Ok(())
}
