//! Rust's standard libraries for the targets, from rustup, or from Debian where rustup cannot download.
//!
//! Debian has no core library for bare metal, only its source. It is built once, into a sysroot in the user's cache
//! folder that also holds Debian's aarch64 library, and rustup knows this sysroot as the toolchain [`LINKED`].

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};

use super::apt::{self, twice};
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::output::tell;
use crate::workspace::{self, find_program};

/// The target of bare-metal Cortex-M4F and Cortex-M7.
pub const CORTEX_M: &str = "thumbv7em-none-eabihf";
/// The target of companion computers: 64-bit Arm with Linux.
pub const AARCH64: &str = "aarch64-unknown-linux-gnu";

/// The rustup toolchain that is made from Debian's packages.
const LINKED: &str = "covey-targets";
/// The compiler of the Debian package rustc-web, which is newer than Debian's default one.
const RUSTC: &str = "/usr/bin/rustc";
/// Its standard library for this computer.
const HOST_LIBRARY: &str = "/usr/lib/rustlib/x86_64-unknown-linux-gnu";

/// The toolchain that builds for the targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The one that runs `cargo xtask`.
    Own,
    /// The one that is made from Debian's packages, [`LINKED`].
    Linked,
}

impl Toolchain {
    /// The toolchain that has the libraries of all targets, if there is one.
    pub fn find() -> Option<Self> {
        let own = Cmd::new("rustc").args(["--print", "sysroot"]).read().ok();
        if own.is_some_and(|sysroot| is_complete(Path::new(sysroot.trim()))) {
            return Some(Self::Own);
        }
        is_linked().then_some(Self::Linked)
    }

    /// The toolchain that has the libraries of all targets.
    ///
    /// # Errors
    /// There is none.
    pub fn required() -> Result<Self> {
        Self::find().ok_or_else(|| Error::Missing { names: "rust-targets".into() })
    }

    /// A command that runs cargo of this toolchain.
    pub fn cargo(self) -> Cmd {
        match self {
            Self::Own => Cmd::cargo(),
            Self::Linked => Cmd::new("rustup").args(["run", LINKED, "cargo"]),
        }
    }

    /// A command that runs cargo of this toolchain with a linker for [`CORTEX_M`].
    pub fn cortex_m_cargo(self) -> Cmd {
        match self {
            Self::Own => self.cargo(),
            // The linked toolchain has no linker of its own.
            Self::Linked => {
                let linker = rust_lld().unwrap_or_else(|| "arm-none-eabi-ld".into());
                self.cargo().env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker)
            }
        }
    }
}

/// Installs the libraries of the targets: with rustup if `ask_rustup` and it can download them, else from Debian.
///
/// # Errors
/// Neither rustup nor Debian has them.
pub fn install(ask_rustup: bool) -> Result<()> {
    if ask_rustup && find_program(&["rustup"]).is_some() {
        let add = Cmd::new("rustup").args(["target", "add", CORTEX_M, AARCH64]);
        tell!("setup: {add}");
        match twice(|| add.read()) {
            Ok(_) => return Ok(()),
            Err(error) => tell!("setup: rustup cannot ({error})\nsetup: taking Debian's packages instead"),
        }
    }
    let linker = if rust_lld().is_some() { &[][..] } else { &["binutils-arm-none-eabi"] };
    apt::install(&[&["rustc-web", "rust-web-src"], linker].concat())?;
    build_sysroot()?;
    Cmd::new("rustup").args(["toolchain", "link", LINKED]).arg(sysroot()?).read()?;
    if is_linked() { Ok(()) } else { Err(Error::Setup(format!("the linked toolchain {LINKED} does not work"))) }
}

/// Whether a sysroot has a core library for each target.
fn is_complete(sysroot: &Path) -> bool {
    [CORTEX_M, AARCH64].iter().all(|target| {
        fs::read_dir(sysroot.join("lib/rustlib").join(target).join("lib"))
            .is_ok_and(|files| files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-")))
    })
}

/// Whether the toolchain [`LINKED`] is complete and rustup can run it.
fn is_linked() -> bool {
    sysroot().is_ok_and(|sysroot| is_complete(&sysroot))
        && Cmd::new("rustup").args(["run", LINKED, "rustc", "--version"]).succeeds()
}

/// The folder for the sysroot of Debian's compiler; its name has the compiler's version.
fn sysroot() -> Result<PathBuf> {
    let version = Cmd::new(RUSTC).arg("--version").read()?;
    let version = version.split_whitespace().nth(1).unwrap_or("unknown");
    Ok(workspace::cache().join(format!("sysroot-{version}")))
}

/// The linker that comes with the toolchain of `cargo xtask`, where it has one.
fn rust_lld() -> Option<PathBuf> {
    let sysroot = Cmd::new("rustc").args(["--print", "sysroot"]).read().ok()?;
    let linker = Path::new(sysroot.trim()).join("lib/rustlib/x86_64-unknown-linux-gnu/bin/rust-lld");
    linker.is_file().then_some(linker)
}

/// Builds the sysroot. It is built in a draft folder that is renamed at the end, so a sysroot is either complete or
/// absent.
fn build_sysroot() -> Result<()> {
    let done = sysroot()?;
    if is_complete(&done) {
        return Ok(());
    }
    let draft = done.with_extension("draft");
    for old in [&done, &draft] {
        match fs::remove_dir_all(old) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(Error::file(old)(error)),
            _ => {}
        }
    }
    let libraries = draft.join("lib/rustlib");
    create(&libraries.join(CORTEX_M).join("lib"))?;
    link(Path::new(HOST_LIBRARY), &libraries.join("x86_64-unknown-linux-gnu"))?;
    core_for_cortex_m(&draft, &libraries.join(CORTEX_M).join("lib"))?;
    std_for_aarch64(&draft, &done, &libraries)?;
    programs(&draft, &done)?;
    fs::rename(&draft, &done).map_err(Error::file(&done))
}

/// Builds the libraries core and alloc from Debian's source into `into`, with the bitcode that link-time optimisation
/// needs.
fn core_for_cortex_m(draft: &Path, into: &Path) -> Result<()> {
    tell!("setup: building Rust's core library for {CORTEX_M}, once (about half a minute)");
    let package = draft.join("core");
    create(&package.join("src"))?;
    let manifest =
        "[package]\nname = \"empty\"\nedition = \"2024\"\n[workspace]\n[profile.release]\npanic = \"abort\"\n";
    write(&package.join("Cargo.toml"), manifest)?;
    write(&package.join("src/lib.rs"), "#![no_std]\n")?;
    Cmd::cargo()
        .args(["build", "--release", "-Zbuild-std=core,alloc", "--target", CORTEX_M, "--target-dir", "target"])
        .env("RUSTFLAGS", "-Cembed-bitcode=yes")
        // -Zbuild-std needs this variable. It is set for this build only, the project is built without it.
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTC", RUSTC)
        .folder(&package)
        .read()?;
    let built = package.join("target").join(CORTEX_M).join("release/deps");
    for file in fs::read_dir(&built).map_err(Error::file(&built))?.flatten() {
        let name = file.file_name();
        let wanted = ["libcore-", "liballoc-", "libcompiler_builtins-"];
        let text = name.to_string_lossy();
        if wanted.iter().any(|start| text.starts_with(start)) && text.ends_with(".rlib") {
            fs::copy(file.path(), into.join(&name)).map_err(Error::file(file.path()))?;
        }
    }
    fs::remove_dir_all(&package).map_err(Error::file(&package))
}

/// Downloads and unpacks Debian's standard library for arm64, without adding that architecture to the system.
fn std_for_aarch64(draft: &Path, done: &Path, libraries: &Path) -> Result<()> {
    tell!("setup: fetching Rust's standard library for {AARCH64}");
    let apt = draft.join("apt");
    create(&apt.join("lists/partial"))?;
    create(&apt.join("cache/archives/partial"))?;
    let apt_get = |verb: &[&str]| {
        Cmd::new("apt-get")
            .args(["-q", "-o", "APT::Architectures::=amd64", "-o", "APT::Architectures::=arm64"])
            .args(["-o", &format!("Dir::State::lists={}", apt.join("lists").display())])
            .args(["-o", &format!("Dir::Cache={}", apt.join("cache").display())])
            // The download goes to a folder of this user, where apt's own download user could not write.
            .args(["-o", "APT::Sandbox::User="])
            .args(verb)
            .folder(&apt)
    };
    twice(|| {
        apt_get(&["update"]).read()?;
        apt_get(&["download", "libstd-rust-web-dev:arm64"]).read()
    })?;
    let files = fs::read_dir(&apt).map_err(Error::file(&apt))?.flatten();
    let package = files.map(|file| file.path()).find(|path| path.extension().is_some_and(|end| end == "deb"));
    let package = package.ok_or_else(|| Error::Setup("apt-get download left no package behind".into()))?;
    Cmd::new("dpkg").arg("-x").arg(package).arg(draft.join("arm64")).read()?;
    fs::remove_dir_all(&apt).map_err(Error::file(&apt))?;
    link(&done.join("arm64/usr/lib/rustlib").join(AARCH64), &libraries.join(AARCH64))
}

/// Puts the programs of the toolchain into the sysroot: a script that runs Debian's compiler with this sysroot, and a
/// link to the cargo that runs `cargo xtask`.
fn programs(draft: &Path, done: &Path) -> Result<()> {
    let bin = draft.join("bin");
    create(&bin)?;
    let rustc = bin.join("rustc");
    write(&rustc, &format!("#!/bin/sh\nexec {RUSTC} --sysroot '{}' \"$@\"\n", done.display()))?;
    fs::set_permissions(&rustc, fs::Permissions::from_mode(0o755)).map_err(Error::file(&rustc))?;
    let cargo = Cmd::new("rustup").args(["which", "cargo"]).read()?;
    link(Path::new(cargo.trim()), &bin.join("cargo"))
}

/// Creates a folder and the folders around it.
fn create(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::file(folder))
}

/// Writes a text file.
fn write(file: &Path, text: &str) -> Result<()> {
    fs::write(file, text).map_err(Error::file(file))
}

/// Makes a symbolic link to `to` at `at`.
fn link(to: &Path, at: &Path) -> Result<()> {
    symlink(to, at).map_err(Error::file(at))
}
