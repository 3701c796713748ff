//! Splitting `use` declarations into single imports.

use syn::UseTree;

/// One name that a `use` declaration imports, or all names of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Import {
    /// The path of what is imported, or of the module whose names are all imported.
    pub path: Vec<String>,
    /// The name that it gets in the importing module; `None` where all names are imported.
    pub name: Option<String>,
    /// The line of the last name of the path, from 1.
    pub line: usize,
}

/// The imports of a `use` declaration, without those from other crates by a leading `::`.
pub fn imports(item: &syn::ItemUse) -> Vec<Import> {
    let mut found = Vec::new();
    if item.leading_colon.is_none() {
        flatten(&item.tree, &mut Vec::new(), &mut found);
    }
    found
}

/// Adds the imports of a part of a `use` declaration that stands after `path`.
fn flatten(tree: &UseTree, path: &mut Vec<String>, found: &mut Vec<Import>) {
    match tree {
        UseTree::Path(inner) => {
            path.push(inner.ident.to_string());
            flatten(&inner.tree, path, found);
            path.pop();
        }
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, path, found)),
        UseTree::Glob(glob) => {
            let line = glob.star_token.spans[0].start().line;
            found.push(Import { path: path.clone(), name: None, line });
        }
        UseTree::Name(name) => found.push(import(path, &name.ident, &name.ident)),
        UseTree::Rename(renamed) => found.push(import(path, &renamed.ident, &renamed.rename)),
    }
}

/// The import of `last` from the module `before`, as `name`.
fn import(before: &[String], last: &syn::Ident, name: &syn::Ident) -> Import {
    let mut path = before.to_vec();
    let mut name = name.to_string();
    // `a::{self}` is `a`.
    if last != "self" || path.is_empty() {
        path.push(last.to_string());
    } else if name == "self" {
        name = path.last().cloned().unwrap_or_default();
    }
    Import { path, name: Some(name), line: last.span().start().line }
}
