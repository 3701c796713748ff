//! Finding the uses of names that are defined in other files.

use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};
use syn::{Expr, ExprCall, ImplItem, Item, ItemUse, Macro, MetaList, Path, Visibility};

use super::graph::Graph;
use super::import::imports;
use super::test_only::{attributes, is_test_only};
use super::tokens::{self, Call, Found};
use super::tree::{Meaning, Place, Tree};

/// Adds every use of a name that is defined in another file to `graph`.
///
/// A re-export is no use, and neither is the name of a module alone. Calls of methods are not found, since only the
/// compiler knows the types of values.
pub fn add_uses(tree: &Tree, graph: &mut Graph) {
    for (module, inside) in tree.modules.iter().enumerate() {
        let mut uses = Uses { tree, module, graph };
        inside.items.iter().for_each(|item| uses.visit_item(item));
    }
}

/// The uses in one module.
struct Uses<'t> {
    tree: &'t Tree,
    module: usize,
    graph: &'t mut Graph,
}

impl Uses<'_> {
    /// Adds the use of a path.
    fn path(&mut self, path: &[String], line: usize) {
        let places = self.tree.resolve(self.module, path);
        self.add(&places, line);
    }

    /// Adds the use of what a path stands for.
    fn add(&mut self, places: &[Place], line: usize) {
        for place in places {
            if let Place::Item { module, name } = place {
                let modules = &self.tree.modules;
                self.graph.add(&modules[self.module].file, &modules[*module].file, name, line);
            }
        }
    }

    /// Adds the import of all names of a module. It is a use of the module's file if that defines any names; the uses
    /// of imported names are found where they stand.
    fn glob(&mut self, path: &[String], line: usize) {
        for place in self.tree.resolve(self.module, path) {
            let Place::Module(module) = place else {
                // All variants of an enum.
                self.add(&[place], line);
                continue;
            };
            let bindings = self.tree.modules[module].names.values().flatten();
            if bindings.into_iter().any(|binding| matches!(binding.meaning, Meaning::Item(_))) {
                self.add(&[Place::Item { module, name: "*".into() }], line);
            }
        }
    }

    /// Adds the uses among the tokens of a macro call or an attribute.
    fn tokens(&mut self, tokens: proc_macro2::TokenStream) {
        for Found { path, line, call } in tokens::paths(tokens) {
            match (path.as_slice(), call) {
                ([name], Call::Macro) => {
                    let places = self.tree.resolve_macro(self.module, name);
                    self.add(&places, line);
                }
                ([name], Call::No) if may_be_variable(name) => {}
                _ => self.path(&path, line),
            }
        }
    }
}

/// Whether a single name is taken for a variable: if it begins with a small letter.
fn may_be_variable(name: &str) -> bool {
    name.starts_with(|c: char| c.is_lowercase() || c == '_')
}

/// The names of a path, without generic arguments.
fn names(path: &Path) -> Vec<String> {
    path.segments.iter().map(|segment| segment.ident.to_string()).collect()
}

impl<'a> Visit<'a> for Uses<'_> {
    fn visit_item(&mut self, item: &'a Item) {
        if !is_test_only(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &'a ImplItem) {
        let attributes = match item {
            ImplItem::Const(item) => &item.attrs,
            ImplItem::Fn(item) => &item.attrs,
            ImplItem::Type(item) => &item.attrs,
            ImplItem::Macro(item) => &item.attrs,
            _ => return,
        };
        if !is_test_only(attributes) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'a ItemUse) {
        if !matches!(item.vis, Visibility::Inherited) {
            return;
        }
        for import in imports(item) {
            match import.name {
                Some(_) => self.path(&import.path, import.line),
                None => self.glob(&import.path, import.line),
            }
        }
    }

    fn visit_path(&mut self, path: &'a Path) {
        let names = names(path);
        let variable = matches!(names.as_slice(), [name] if may_be_variable(name));
        if path.leading_colon.is_none() && !variable {
            self.path(&names, path.span().start().line);
        }
        visit::visit_path(self, path);
    }

    fn visit_expr_call(&mut self, call: &'a ExprCall) {
        if let Expr::Path(function) = &*call.func
            && function.path.leading_colon.is_none()
        {
            self.path(&names(&function.path), function.path.span().start().line);
        }
        visit::visit_expr_call(self, call);
    }

    fn visit_macro(&mut self, call: &'a Macro) {
        if let Some(name) = call.path.get_ident() {
            let places = self.tree.resolve_macro(self.module, &name.to_string());
            self.add(&places, name.span().start().line);
        } else {
            self.visit_path(&call.path);
        }
        self.tokens(call.tokens.clone());
    }

    fn visit_meta_list(&mut self, list: &'a MetaList) {
        self.tokens(list.tokens.clone());
    }
}
