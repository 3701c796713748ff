//! The packages of this repository, from `cargo metadata`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use crate::command::Cmd;
use crate::error::{Error, Result};

/// The manifests of the workspaces of this repository, as paths from its root: the main one, the bare-metal images
/// and the fuzz targets.
const WORKSPACES: [&str; 3] = ["Cargo.toml", "firmware-core/image/Cargo.toml", "fuzz/Cargo.toml"];

/// A package of this repository.
#[derive(Debug)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// The folder of its manifest.
    pub folder: PathBuf,
    /// The root files of its library and its programs.
    pub roots: Vec<PathBuf>,
    /// The packages of this repository that it depends on, with `true` where only its tests do.
    pub dependencies: BTreeMap<String, bool>,
}

/// The output of `cargo metadata`.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Described>,
}

/// A package in the output of `cargo metadata`.
#[derive(Deserialize)]
struct Described {
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

/// Reads the packages of all workspaces of this repository, sorted by name.
///
/// # Errors
/// Cargo fails, or its output is not what is expected.
pub fn packages() -> Result<Vec<Package>> {
    let mut all = Vec::new();
    for manifest in WORKSPACES {
        let command =
            Cmd::cargo().args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path", manifest]);
        let printed = command.read()?;
        let metadata: Metadata = serde_json::from_str(&printed)
            .map_err(|error| Error::Output { command: command.to_string(), printed: error.to_string() })?;
        all.extend(metadata.packages.into_iter().map(Package::from));
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(all)
}

impl From<Described> for Package {
    fn from(described: Described) -> Self {
        let wanted = |target: &Target| target.kind.iter().any(|kind| kind.ends_with("lib") || kind == "bin");
        let mut dependencies = BTreeMap::new();
        for dependency in described.dependencies.into_iter().filter(|dependency| dependency.path.is_some()) {
            let tests_only = dependency.kind.as_deref() == Some("dev");
            let known = dependencies.entry(dependency.name).or_insert(tests_only);
            *known &= tests_only;
        }
        Self {
            name: described.name,
            folder: described.manifest_path.parent().map_or_else(PathBuf::new, PathBuf::from),
            roots: described.targets.into_iter().filter(wanted).map(|target| target.src_path).collect(),
            dependencies,
        }
    }
}
