//! The imports between the modules of a Python package. They are read without Python, which may not be installed.

use std::fs;
use std::path::{Path, PathBuf};

use super::graph::Graph;
use crate::error::{Error, Result};

/// An import of one module or name, by a statement `import` or `from … import`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Import {
    /// The module as it is written, with leading dots where it is relative.
    module: String,
    /// The name that is imported from the module; `None` where the module itself is imported.
    name: Option<String>,
    /// The line of the statement, from 1.
    line: usize,
}

/// Reads the graph of imports between the modules of the package in `folder`, which has the folder's name. Folders
/// called `tests` are left out.
///
/// # Errors
/// A file or a folder cannot be read.
pub fn graph(folder: &Path) -> Result<Graph> {
    let mut files = Vec::new();
    list(folder, &mut files)?;
    let package = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let mut graph = Graph::default();
    for file in &files {
        let text = fs::read_to_string(file).map_err(Error::file(file))?;
        let own = relative(folder, file);
        for import in imports(&text) {
            let Some(module) = inside(&package, &own, &import.module) else { continue };
            // `from package import name`: a module, or something of the package's __init__.
            let named = import.name.as_ref().and_then(|name| file_of(folder, &[module.as_str(), name].join("/")));
            let Some(to) = named.or_else(|| file_of(folder, &module)) else { continue };
            let name = import.name.as_deref().or_else(|| import.module.rsplit('.').next());
            graph.add(&own, &relative(folder, &to), name.unwrap_or_default(), import.line);
        }
    }
    Ok(graph)
}

/// Adds all modules in a folder and in the folders inside.
fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::file(folder))? {
        let path = entry.map_err(Error::file(folder))?.path();
        if path.is_dir() && !path.ends_with("tests") {
            list(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "py") {
            files.push(path);
        }
    }
    Ok(())
}

/// The path of a file from the package's folder.
fn relative(folder: &Path, file: &Path) -> String {
    file.strip_prefix(folder).unwrap_or(file).display().to_string()
}

/// The path of the imported `module` from the package's folder; `None` where it belongs to another package. `own` is
/// the path of the importing file.
fn inside(package: &str, own: &str, module: &str) -> Option<String> {
    let name = module.trim_start_matches('.');
    let dots = module.len() - name.len();
    if dots == 0 {
        let rest = name.strip_prefix(package)?;
        return (rest.is_empty() || rest.starts_with('.')).then(|| rest.trim_start_matches('.').replace('.', "/"));
    }
    // One dot is the folder of the file itself.
    let folder = Path::new(own).ancestors().nth(dots)?;
    Some(folder.join(name.replace('.', "/")).display().to_string())
}

/// The file of a module, or of a package inside the package.
fn file_of(folder: &Path, module: &str) -> Option<PathBuf> {
    let path = folder.join(module.trim_matches('/'));
    [path.with_extension("py"), path.join("__init__.py")].into_iter().find(|file| file.is_file())
}

/// All imports in a source text, also those inside functions and under conditions.
fn imports(text: &str) -> Vec<Import> {
    let mut found = Vec::new();
    for (line, statement) in statements(text) {
        let words = statement.replace(['(', ')'], " ");
        let listed = |names: &str| -> Vec<String> {
            let first_word = |name: &str| name.split_whitespace().next().map(str::to_owned);
            names.split(',').filter_map(first_word).collect()
        };
        if let Some(modules) = words.strip_prefix("import ") {
            found.extend(listed(modules).into_iter().map(|module| Import { module, name: None, line }));
        } else if let Some((module, names)) = words.strip_prefix("from ").and_then(|rest| rest.split_once(" import ")) {
            let module = module.trim().to_owned();
            let names = listed(names).into_iter();
            found.extend(names.map(|name| Import { module: module.clone(), name: Some(name), line }));
        }
    }
    found
}

/// Splits a source text into simple statements and gives the line where each begins. Comments and string literals are
/// left out, and continued lines are joined.
fn statements(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let (mut line, mut depth) = (1, 0usize);
    let mut current = (1, String::new());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let mut length = c.len_utf8();
        let ends = match c {
            '#' => {
                length = rest.find('\n').unwrap_or(rest.len());
                false
            }
            '"' | '\'' => {
                length = quoted(rest);
                false
            }
            '\\' if rest[1..].starts_with('\n') => {
                length = 2;
                current.1.push(' ');
                false
            }
            '(' | '[' | '{' => {
                depth += 1;
                current.1.push(c);
                false
            }
            ')' | ']' | '}' => {
                depth = depth.saturating_sub(1);
                current.1.push(c);
                false
            }
            // A colon outside brackets ends `if …:`, and also the name of an annotated variable, which does no harm.
            '\n' | ';' | ':' if depth == 0 => true,
            c => {
                current.1.push(if c.is_whitespace() { ' ' } else { c });
                false
            }
        };
        line += rest[..length].matches('\n').count();
        rest = &rest[length..];
        if ends {
            found.push(std::mem::take(&mut current));
        }
        if current.1.trim().is_empty() {
            current = (line, String::new());
        }
    }
    found.push(current);
    found.into_iter().map(|(line, statement)| (line, statement.trim().to_owned())).collect()
}

/// The length of the string literal that `text` begins with, its quotes included.
fn quoted(text: &str) -> usize {
    let quote = &text[..1];
    let triple = quote.repeat(3);
    let quote = if text.starts_with(&triple) { triple.as_str() } else { quote };
    let mut at = quote.len();
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        if rest.starts_with(quote) {
            return at + quote.len();
        }
        let skipped = if rest.starts_with('\\') { 2 } else { 1 };
        at += rest.chars().take(skipped).map(char::len_utf8).sum::<usize>();
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::super::graph::Circle;
    use super::*;

    /// The circles of a package `sim` with these files, given as paths and texts.
    fn circles(files: &[(&str, &str)]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        let package = folder.path().join("sim");
        for (name, text) in files {
            let path = package.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        graph(&package).unwrap().circles().iter().map(Circle::line).collect()
    }

    #[test]
    fn python_modules_that_import_each_other_are_a_circle() {
        let with = |import: &'static str| {
            circles(&[
                ("__init__.py", ""),
                (
                    "a.py",
                    "\"\"\"Text:\nfrom sim import c\n\"\"\"\nimport math  # import sim.c\nfrom sim.deep.b import B\n",
                ),
                ("c.py", "from sim import a\n"),
                ("deep/__init__.py", ""),
                ("deep/b.py", import),
                ("tests/test_a.py", "from sim import a\n"),
            ])
        };
        let circle =
            |name: &str, line: usize| vec![format!("a.py -> deep/b.py (B, line 5) -> a.py ({name}, line {line})")];
        assert_eq!(with("import sim.a\n"), circle("a", 1));
        assert_eq!(with("x = '''\n'''\nimport os, sim.a as other\n"), circle("a", 3));
        assert_eq!(with("from sim.a import (\n    X,  # first\n    Y as Z,\n)\n"), circle("X", 1));
        assert_eq!(with("from .. import a\n"), circle("a", 1));
        assert_eq!(with("from ..a \\\n    import X\n"), circle("X", 1));
        assert_eq!(with("if TYPE_CHECKING:\n    from sim import a\n"), circle("a", 2));
        assert_eq!(with("def f(): from sim.a import X\n"), circle("X", 1));
        assert_eq!(
            with("from . import a\nfrom similar import a\nx = 'import sim.a'\nfrom sim.deep import b\n"),
            Vec::<String>::new()
        );
    }
}
