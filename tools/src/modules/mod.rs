//! `cargo xtask modules`: checks that the source files of a crate do not depend on each other in a circle, and that the
//! crates depend on each other as the document on the architecture says.
//!
//! A file depends on another one if it uses a name that is defined there. The files of a circle cannot be understood,
//! tested or moved one by one.

mod arrows;
mod graph;
mod import;
mod packages;
mod paths;
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
use crate::output::print;
use crate::workspace;
use graph::Graph;
use packages::{Package, packages};

/// The Python packages that are checked, as paths from the workspace root.
const PYTHON: [&str; 2] = ["sitl-bridge/simlink", "sitl-bridge/sitl"];

/// Options of `cargo xtask modules`.
#[derive(clap::Args)]
pub struct Args {
    /// Print every dependency between the files of a circle, not only the shortest circle.
    #[arg(long)]
    all: bool,
}

/// Checks the source files of all libraries, programs and Python packages; tests, benches and examples are left out.
///
/// # Errors
/// There are circles, or the crates' dependencies differ from the document; the error names all of them. Or a file
/// cannot be read or parsed.
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
        complaints.push("To break a circle, move what both files need into a file of its own, or pass it in.".into());
    }
    let path = root.join(arrows::DOCUMENT);
    let document = fs::read_to_string(&path).map_err(Error::file(&path))?;
    complaints.extend(arrows::differences(&document, &packages));
    complaints.extend(paths::missing(&document, &root));
    if complaints.is_empty() {
        return print(&format!(
            "no circle in {} crates and {} Python packages; the crates' dependencies and the files are those of {}\n",
            packages.len(),
            PYTHON.len(),
            arrows::DOCUMENT
        ));
    }
    Err(Error::Modules(complaints.join("\n")))
}

/// The dependencies between the files of a package's library and programs.
fn graph_of(package: &Package) -> Result<Graph> {
    let mut graph = Graph::default();
    for root in &package.roots {
        uses::add_uses(&read::read(&package.folder, root)?, &mut graph);
    }
    Ok(graph)
}

/// A line for each circle of a package, and with `all` also a line for each pair of files in it.
fn circles(package: &str, graph: &Graph, all: bool) -> Vec<String> {
    let mut lines = Vec::new();
    for circle in graph.circles() {
        lines.push(format!("{package}: {}", circle.line()));
        if circle.len() > 2 {
            lines.push(format!("  {} files depend on each other in this circle", circle.len()));
        }
        if all {
            lines.extend(circle.all().into_iter().map(|line| format!("  {line}")));
        }
    }
    lines
}
