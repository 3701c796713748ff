//! Reading executables in ELF format.

use std::fs;
use std::path::Path;

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionKind};

use crate::error::{Error, Result};

/// Sizes of the parts of an executable, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Code.
    pub text: u64,
    /// Constants, which include the interrupt table and the initial values of variables.
    pub rodata: u64,
    /// Variables: static RAM.
    pub static_ram: u64,
}

impl Sizes {
    /// Reads the sizes of an executable.
    ///
    /// # Errors
    /// The file cannot be read, or is no executable.
    pub fn of(path: &Path) -> Result<Self> {
        let mut sizes = Self::default();
        with_elf(path, |elf| {
            for section in elf.sections() {
                match section.kind() {
                    SectionKind::Text => sizes.text += section.size(),
                    SectionKind::ReadOnlyData | SectionKind::ReadOnlyString | SectionKind::ReadOnlyDataWithRel => {
                        sizes.rodata += section.size();
                    }
                    SectionKind::Data => {
                        sizes.static_ram += section.size();
                        sizes.rodata += section.size();
                    }
                    SectionKind::UninitializedData => sizes.static_ram += section.size(),
                    _ => {}
                }
            }
            Ok(())
        })?;
        Ok(sizes)
    }
}

/// The address of a symbol in an executable.
///
/// # Errors
/// The file cannot be read, is no executable, or has no such symbol.
pub fn address_of(path: &Path, symbol: &str) -> Result<u64> {
    with_elf(path, |elf| {
        let found = elf.symbols().find(|entry| entry.name() == Ok(symbol));
        found.map(|entry| entry.address()).ok_or_else(|| Error::content(path, format!("it has no symbol {symbol}")))
    })
}

/// Checks by the names of its symbols that a program has no panic and no heap. A program with a panic branch of Rust
/// does not even link; this check also finds other code that aborts.
///
/// # Errors
/// The program has such symbols; the error names them. Or the file cannot be read.
pub fn assert_panic_free(path: &Path) -> Result<()> {
    const UNWANTED: [&str; 4] = ["panic", "unwrap_failed", "__rust_alloc", "malloc"];
    with_elf(path, |elf| {
        let names = elf.symbols().filter_map(|symbol| symbol.name().ok());
        let found: Vec<&str> = names.filter(|name| UNWANTED.iter().any(|unwanted| name.contains(unwanted))).collect();
        if found.is_empty() {
            Ok(())
        } else {
            Err(Error::content(path, format!("panics or a heap: {}", found.join(", "))))
        }
    })
}

/// Parses an executable and calls `look` with it.
///
/// # Errors
/// The file cannot be read or is no executable, and the errors of `look`.
pub fn with_elf<T>(path: &Path, look: impl FnOnce(&object::File<'_>) -> Result<T>) -> Result<T> {
    let bytes = fs::read(path).map_err(Error::file(path))?;
    let elf = object::File::parse(&*bytes).map_err(|error| Error::content(path, error.to_string()))?;
    look(&elf)
}
