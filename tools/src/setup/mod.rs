//! `cargo xtask setup`: installs what the tests and the target builds need beyond rustup and a C compiler.

mod apt;
mod item;
pub mod rust_targets;
pub mod simlink;

pub use item::Item;

use crate::error::{Error, Result};
use crate::output::{print, tell};

/// Options of `cargo xtask setup`.
#[derive(clap::Args)]
pub struct Args {
    /// Only report what is missing; exit with an error when something is.
    #[arg(long)]
    check: bool,
    /// Take Rust's libraries for the targets from Debian even where rustup could download them.
    #[arg(long)]
    no_rustup: bool,
    /// Only these items; all when none is named.
    #[arg(value_enum)]
    items: Vec<Item>,
}

/// Installs what is missing, or only reports it with `--check`.
///
/// # Errors
/// Something is missing and cannot be installed, or something is missing and `--check` is given.
pub fn main(args: &Args) -> Result<()> {
    let items = if args.items.is_empty() { Item::ALL } else { &args.items };
    if args.no_rustup && !args.check {
        rust_targets::install(false)?;
    }
    if !args.check {
        return install(items);
    }
    for &item in items {
        let word = if item.is_present() { "ok     " } else { "missing" };
        print(&format!("{word} {:<14} {}\n", item.name(), item.purpose()))?;
    }
    let names: Vec<_> = items.iter().filter(|item| !item.is_present()).map(|item| item.name()).collect();
    if names.is_empty() { Ok(()) } else { Err(Error::Missing { names: names.join(", ") }) }
}

/// Installs those of `items` that are missing.
///
/// # Errors
/// A package cannot be installed, or an item is still missing afterwards.
pub fn install(items: &[Item]) -> Result<()> {
    let mut missing: Vec<Item> = items.iter().copied().filter(|item| !item.is_present()).collect();
    if missing.is_empty() {
        tell!("setup: all {} items are there, nothing to do", items.len());
        return Ok(());
    }
    // The simulated autopilots' environment is made by Python's venv.
    if missing.contains(&Item::Simlink) && !missing.contains(&Item::PythonVenv) && !Item::PythonVenv.is_present() {
        missing.insert(0, Item::PythonVenv);
    }
    for item in &missing {
        tell!("setup: {} is missing ({})", item.name(), item.purpose());
    }
    let packages: Vec<&str> = missing.iter().flat_map(|item| item.packages()).copied().collect();
    if !packages.is_empty() {
        apt::install(&packages)?;
    }
    if missing.contains(&Item::Simlink) {
        simlink::install()?;
    }
    if missing.contains(&Item::RustTargets) {
        rust_targets::install(true)?;
    }
    for item in &missing {
        if !item.is_present() {
            return Err(Error::Setup(format!(
                "{} is still missing although its installation succeeded; `cargo xtask setup --check` says what it is for",
                item.name(),
            )));
        }
        tell!("setup: {} is ready", item.name());
    }
    Ok(())
}
