//! The packages of this repository, as cargo tells them.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use crate::command::Cmd;
use crate::error::{Error, Result};

/// Manifests of the workspaces: one for the host, and two that are built in other ways.
const WORKSPACES: [&str; 3] = ["Cargo.toml", "firmware-core/image/Cargo.toml", "fuzz/Cargo.toml"];

/// A package.
#[derive(Debug)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// The folder of its manifest.
    pub folder: PathBuf,
    /// The root files of its library and its programs.
    pub roots: Vec<PathBuf>,
    /// The packages of this repository that it depends on, and whether its tests alone do.
    pub dependencies: BTreeMap<String, bool>,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Told>,
}

#[derive(Deserialize)]
struct Told {
    name: String,
    manifest_path: PathBuf,
    targets: Vec<Target>,
    dependencies: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Target {
    kind: Vec<String>,
    src_path: PathBuf,
}

#[derive(Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
    path: Option<PathBuf>,
}

/// All packages of all workspaces here, by name.
///
/// # Errors
/// Cargo fails, or tells something else than expected.
pub fn packages() -> Result<Vec<Package>> {
    let mut all = Vec::new();
    for manifest in WORKSPACES {
        let command =
            Cmd::cargo().args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path", manifest]);
        let printed = command.read()?;
        let told: Metadata = serde_json::from_str(&printed)
            .map_err(|error| Error::Output { command: command.to_string(), printed: error.to_string() })?;
        all.extend(told.packages.into_iter().map(Package::from));
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(all)
}

impl From<Told> for Package {
    fn from(told: Told) -> Self {
        let wanted = |target: &Target| target.kind.iter().any(|kind| kind.ends_with("lib") || kind == "bin");
        let mut dependencies = BTreeMap::new();
        for dependency in told.dependencies.into_iter().filter(|dependency| dependency.path.is_some()) {
            let tests_only = dependency.kind.as_deref() == Some("dev");
            let known = dependencies.entry(dependency.name).or_insert(tests_only);
            *known &= tests_only;
        }
        Self {
            name: told.name,
            folder: told.manifest_path.parent().map_or_else(PathBuf::new, PathBuf::from),
            roots: told.targets.into_iter().filter(wanted).map(|target| target.src_path).collect(),
            dependencies,
        }
    }
}
