//! The folders that `cargo xtask` works with, and programs on the search path.

use std::env;
use std::path::PathBuf;

/// The root folder of the workspace. `cargo run` says where this package lies; where it does not, the path at build
/// time is taken.
pub fn root() -> PathBuf {
    let package = env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from);
    package.parent().map_or_else(|| package.clone(), PathBuf::from)
}

/// The folder where cargo puts what it builds.
pub fn target_folder() -> PathBuf {
    let root = root();
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |folder| root.join(folder))
}

/// The folder for the images, the C library and the sample actors of the target builds.
pub fn targets_folder() -> PathBuf {
    target_folder().join("targets")
}

/// The folder in the user's cache for what is built or downloaded once for a computer.
pub fn cache() -> PathBuf {
    let base = env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let base = base.or_else(|| env::var_os("HOME").map(|home| PathBuf::from(home).join(".cache")));
    base.unwrap_or_else(env::temp_dir).join("covey")
}

/// The path of the first of the programs `names` that is on the search path (`PATH`).
pub fn find_program(names: &[&str]) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    let folders: Vec<PathBuf> = env::split_paths(&path).collect();
    names.iter().find_map(|name| folders.iter().map(|folder| folder.join(name)).find(|file| file.is_file()))
}
