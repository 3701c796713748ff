//! Reading the source files of a library or program into its module tree.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Expr, Ident, Item, ItemMod, Lit, Meta, Visibility};

use super::import::imports;
use super::test_only::{attributes, is_test_only};
use super::tree::{Binding, Meaning, Module, Tree};
use crate::error::{Error, Result};

/// Reads the source file `root` of a library or program and all files of its `mod` declarations. Files are named by
/// their paths from the folder `package`.
///
/// # Errors
/// A file is missing or cannot be parsed.
pub fn read(package: &Path, root: &Path) -> Result<Tree> {
    let canonical = |path: &Path| path.canonicalize().map_err(Error::file(path));
    let (package, root) = (canonical(package)?, canonical(root)?);
    let mut reader = Reader { package: &package, tree: Tree::default(), exported: Vec::new() };
    let folder = root.parent().unwrap_or(&package);
    reader.file(&root, folder, None)?;
    let Reader { mut tree, exported, .. } = reader;
    for (name, module) in exported {
        let binding = Binding { public: true, meaning: Meaning::Item(module) };
        tree.modules[0].names.entry(name).or_default().push(binding);
    }
    Ok(tree)
}

/// The module tree while it is read.
struct Reader<'p> {
    package: &'p Path,
    tree: Tree,
    /// Names of exported macros, which are names of the root module, and the modules that define them.
    exported: Vec<(String, usize)>,
}

/// The folders in which the files of a module's `mod` declarations lie.
struct Folders {
    /// For `mod x;`.
    children: PathBuf,
    /// For `mod x;` with `#[path]`.
    paths: PathBuf,
}

impl Reader<'_> {
    /// Reads a file whose child modules lie in `children`, and returns the number of its module.
    fn file(&mut self, file: &Path, children: &Path, parent: Option<usize>) -> Result<usize> {
        let text = fs::read_to_string(file).map_err(Error::file(file))?;
        let parsed = syn::parse_file(&text).map_err(|error| {
            let start = error.span().start();
            Error::content(file, format!("line {}: {error}", start.line))
        })?;
        let name = file.strip_prefix(self.package).unwrap_or(file).display().to_string();
        let folders =
            Folders { children: children.into(), paths: file.parent().map_or_else(PathBuf::new, Path::to_path_buf) };
        let items = if is_test_only(&parsed.attrs) { Vec::new() } else { parsed.items };
        self.module(name, items, &folders, parent)
    }

    /// Adds a module with these items, reads its child modules, and returns its number.
    fn module(&mut self, file: String, items: Vec<Item>, folders: &Folders, parent: Option<usize>) -> Result<usize> {
        let number = self.tree.modules.len();
        let mut kept = Vec::new();
        let mut children = Vec::new();
        for item in items.into_iter().filter(|item| !is_test_only(attributes(item))) {
            match item {
                Item::Mod(child) => children.push(child),
                other => kept.push(other),
            }
        }
        let mut names = Names { module: number, bound: HashMap::new(), globs: Vec::new() };
        kept.iter().for_each(|item| names.bind(item));
        let inner = names.of_bodies(&kept);
        for (name, bindings) in inner.bound {
            names.bound.entry(name).or_insert(bindings);
        }
        names.globs.extend(inner.globs);
        let Names { bound, globs, .. } = names;
        self.exported.extend(kept.iter().filter_map(exported_macro).map(|name| (name, number)));
        self.tree.modules.push(Module { file: file.clone(), items: kept, parent, names: bound, globs });
        for child in children {
            let name = child.ident.to_string();
            let binding = |meaning| Binding { public: is_public(&child.vis), meaning };
            let inside = self.child(&file, child.clone(), folders, number)?;
            let names = &mut self.tree.modules[number].names;
            names.entry(name).or_default().push(binding(Meaning::Module(inside)));
        }
        Ok(number)
    }

    /// Reads a child module, which may be in a file of its own or inline, and returns its number.
    fn child(&mut self, file: &str, child: ItemMod, folders: &Folders, parent: usize) -> Result<usize> {
        let name = child.ident.to_string();
        let folder = folders.children.join(&name);
        if let Some((_, items)) = child.content {
            let inside = Folders { children: folder.clone(), paths: folder };
            return self.module(file.into(), items, &inside, Some(parent));
        }
        if let Some(path) = child.attrs.iter().find_map(path_attribute) {
            let found = folders.paths.join(path);
            // The child modules of such a file lie beside it, as those of a mod.rs do.
            let found = found.canonicalize().map_err(Error::file(found))?;
            let beside = found.parent().map_or_else(PathBuf::new, Path::to_path_buf);
            return self.file(&found, &beside, Some(parent));
        }
        let (own, inner) = (folders.children.join(format!("{name}.rs")), folder.join("mod.rs"));
        self.file(if inner.is_file() { &inner } else { &own }, &folder, Some(parent))
    }
}

/// The name of a macro with `#[macro_export]`.
fn exported_macro(item: &Item) -> Option<String> {
    let Item::Macro(item) = item else { return None };
    let exported = item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_export"));
    item.ident.as_ref().filter(|_| exported).map(Ident::to_string)
}

/// The path in an attribute `#[path = "…"]`.
fn path_attribute(attribute: &Attribute) -> Option<String> {
    let Meta::NameValue(pair) = &attribute.meta else { return None };
    match &pair.value {
        Expr::Lit(literal) if pair.path.is_ident("path") => match &literal.lit {
            Lit::Str(path) => Some(path.value()),
            _ => None,
        },
        _ => None,
    }
}

/// The names of a module, collected from its items.
struct Names {
    module: usize,
    bound: HashMap<String, Vec<Binding>>,
    globs: Vec<Binding>,
}

impl Names {
    /// The names that are declared inside functions. They are treated as private names of the module, unless it has a
    /// name of its own that is the same. That ignores in which function a name is valid, which makes no difference in
    /// practice.
    fn of_bodies(&self, items: &[Item]) -> Self {
        let mut inner = Self { module: self.module, bound: HashMap::new(), globs: Vec::new() };
        // This visits the parts of the item, but not the item itself.
        items.iter().for_each(|item| visit::visit_item(&mut inner, item));
        for binding in inner.bound.values_mut().flatten().chain(&mut inner.globs) {
            binding.public = false;
        }
        inner
    }

    /// Adds the names that an item declares.
    fn bind(&mut self, item: &Item) {
        let item_here = Meaning::Item(self.module);
        match item {
            Item::Use(declaration) => {
                let public = is_public(&declaration.vis);
                for import in imports(declaration) {
                    let binding = Binding { public, meaning: Meaning::Import(import.path) };
                    match import.name {
                        Some(name) => self.bound.entry(name).or_default().push(binding),
                        None => self.globs.push(binding),
                    }
                }
            }
            Item::ForeignMod(foreign) => {
                for item in &foreign.items {
                    match item {
                        syn::ForeignItem::Fn(item) => self.add(&item.sig.ident, &item.vis, item_here.clone()),
                        syn::ForeignItem::Static(item) => self.add(&item.ident, &item.vis, item_here.clone()),
                        _ => {}
                    }
                }
            }
            Item::Const(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Enum(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Fn(item) => self.add(&item.sig.ident, &item.vis, item_here),
            Item::Static(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Struct(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Trait(item) => self.add(&item.ident, &item.vis, item_here),
            Item::TraitAlias(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Type(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Union(item) => self.add(&item.ident, &item.vis, item_here),
            Item::Macro(item) => {
                if let Some(name) = &item.ident {
                    self.add(name, &Visibility::Inherited, item_here);
                }
            }
            _ => {}
        }
    }

    /// Adds a name.
    fn add(&mut self, name: &Ident, visibility: &Visibility, meaning: Meaning) {
        let binding = Binding { public: is_public(visibility), meaning };
        self.bound.entry(name.to_string()).or_default().push(binding);
    }
}

impl<'a> Visit<'a> for Names {
    fn visit_item(&mut self, item: &'a Item) {
        if !is_test_only(attributes(item)) {
            self.bind(item);
            visit::visit_item(self, item);
        }
    }
}

/// Whether there is any `pub`, also a restricted one.
fn is_public(visibility: &Visibility) -> bool {
    !matches!(visibility, Visibility::Inherited)
}
