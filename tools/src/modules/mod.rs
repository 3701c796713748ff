//! `cargo xtask modules`: no module needs, round a circle, itself, and the crates depend on each other as drawn.
//!
//! A circle is a group of source files of which each uses names of the others: none of them can be read, tested or
//! moved alone.

mod arrows;
mod graph;
mod import;
mod packages;
mod python;
mod read;
mod test_only;
#[cfg(test)]
mod tests;
mod tokens;
mod tree;
mod uses;

use std::fs;

use crate::error::{Error, Result};
use crate::workspace;
use graph::Graph;
use packages::{Package, packages};

/// The Python packages, as paths from the workspace root.
const PYTHON: [&str; 1] = ["sitl-bridge/simlink"];

/// Options of `cargo xtask modules`.
#[derive(clap::Args)]
pub struct Args {
    /// Print every reference inside each circle, not only the shortest way round.
    #[arg(long)]
    all: bool,
}

/// Looks at all source files of libraries, programs and Python packages, without tests, benches and examples.
///
/// # Errors
/// There is a circle, or a difference between the crates' dependencies and the document: all are named. Or a file
/// cannot be read.
pub fn main(args: &Args) -> Result<()> {
    let root = workspace::root();
    let packages = packages()?;
    let mut complaints = Vec::new();
    for package in &packages {
        complaints.extend(circles(&package.name, &graph_of(package)?, args.all));
    }
    for folder in PYTHON {
        complaints.extend(circles(folder, &python::graph(&root.join(folder))?, args.all));
    }
    if !complaints.is_empty() {
        complaints.push("  a circle: move what both need into a file of its own, or pass it in".into());
    }
    let path = root.join(arrows::DOCUMENT);
    let document = fs::read_to_string(&path).map_err(Error::file(&path))?;
    complaints.extend(arrows::differences(&document, &packages));
    if complaints.is_empty() {
        println!(
            "no circle in {} crates and {} Python package; the crates' dependencies are those of {}",
            packages.len(),
            PYTHON.len(),
            arrows::DOCUMENT
        );
        return Ok(());
    }
    Err(Error::Modules(complaints.join("\n")))
}

/// The references between the files of a package's library and programs.
fn graph_of(package: &Package) -> Result<Graph> {
    let mut graph = Graph::default();
    for root in &package.roots {
        uses::add_uses(&read::read(&package.folder, root)?, &mut graph);
    }
    Ok(graph)
}

/// A line for each circle, and with `all` one for each pair of files in it.
fn circles(package: &str, graph: &Graph, all: bool) -> Vec<String> {
    let mut lines = Vec::new();
    for circle in graph.circles() {
        lines.push(format!("{package}: {}", circle.line()));
        if circle.len() > 2 {
            lines.push(format!("  {} files of {package} need each other in this circle", circle.len()));
        }
        if all {
            lines.extend(circle.all().into_iter().map(|line| format!("  {line}")));
        }
    }
    lines
}
