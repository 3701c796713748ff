//! The modules of one target, the names in them, and where each name is defined.

use std::collections::HashMap;

use syn::Item;

/// The module tree of a library or a program. Modules are identified by their numbers; the root is 0.
#[derive(Default)]
pub struct Tree {
    /// The modules, by number.
    pub modules: Vec<Module>,
}

/// A module, which is a file or an inline part of one.
pub struct Module {
    /// The file of the module, as a path from the package's folder.
    pub file: String,
    /// The items of the module, without child modules and without items for tests.
    pub items: Vec<Item>,
    /// The number of the parent module; `None` for the root.
    pub parent: Option<usize>,
    /// The names in the module. A name can have several meanings: as a type and as a function, or under different
    /// `cfg`.
    pub names: HashMap<String, Vec<Binding>>,
    /// The imports of all names of another module.
    pub globs: Vec<Binding>,
}

/// One meaning of a name.
#[derive(Clone, Debug)]
pub struct Binding {
    /// Whether the name can be used outside the module; any `pub` counts, also a restricted one.
    pub public: bool,
    /// What the name stands for.
    pub meaning: Meaning,
}

/// What a name stands for.
#[derive(Clone, Debug)]
pub enum Meaning {
    /// A type, function, constant or macro that is defined in the module of this number.
    Item(usize),
    /// The child module of this number.
    Module(usize),
    /// An import of this path.
    Import(Vec<String>),
}

/// What a path stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The module of this number.
    Module(usize),
    /// Something that is defined in a module.
    Item {
        /// The number of the module.
        module: usize,
        /// Its name in the module.
        name: String,
    },
}

/// The imports that are being resolved, by module, name and number. An import that leads back to itself is not resolved
/// again.
type Followed = Vec<(usize, String, usize)>;

impl Tree {
    /// What a path in the module `from` stands for. The result is empty for paths of other crates and for variables,
    /// and has more than one element where a name has several meanings.
    pub fn resolve(&self, from: usize, path: &[String]) -> Vec<Place> {
        self.follow(from, path, &mut Followed::new())
    }

    /// What the macro name `name` in the module `from` stands for. A macro of `macro_rules!` is also valid in the child
    /// modules that are declared after it.
    pub fn resolve_macro(&self, from: usize, name: &str) -> Vec<Place> {
        let mut at = Some(from);
        while let Some(module) = at {
            if let Some(found) = self.look_up(module, name, from, &mut Followed::new()) {
                return found;
            }
            at = self.modules[module].parent;
        }
        Vec::new()
    }

    /// As [`Self::resolve`], while the imports `followed` are being resolved.
    fn follow(&self, from: usize, path: &[String], followed: &mut Followed) -> Vec<Place> {
        let (mut at, mut rest) = (from, path);
        while let [first, after @ ..] = rest {
            match first.as_str() {
                "crate" => at = 0,
                "super" => at = self.modules[at].parent.unwrap_or(at),
                "self" => {}
                _ => break,
            }
            rest = after;
        }
        let Some((first, after)) = rest.split_first() else { return vec![Place::Module(at)] };
        let mut places = match self.look_up(at, first, from, followed) {
            Some(places) => places,
            // The name of another crate or of the standard library, or a variable.
            None if rest.len() == path.len() => Vec::new(),
            None => vec![Place::Item { module: at, name: first.clone() }],
        };
        for name in after {
            let modules: Vec<usize> = places.iter().filter_map(Place::module).collect();
            if modules.is_empty() {
                // What follows is a variant or an associated item.
                break;
            }
            let inside = |module: usize| {
                let found = self.look_up(module, name, from, followed);
                // The name is not in the source text, so a macro has defined it.
                found.unwrap_or_else(|| vec![Place::Item { module, name: name.clone() }])
            };
            places = modules.into_iter().flat_map(inside).collect();
        }
        places
    }

    /// What `name` stands for in a module, seen from the module `viewer`; `None` where the module has no such name.
    fn look_up(&self, module: usize, name: &str, viewer: usize, followed: &mut Followed) -> Option<Vec<Place>> {
        let visible = |binding: &&Binding| binding.public || self.is_within(viewer, module);
        let Module { names, globs, .. } = &self.modules[module];
        let bindings: Vec<&Binding> = names.get(name).into_iter().flatten().filter(visible).collect();
        if !bindings.is_empty() {
            let places = bindings.iter().enumerate().flat_map(|(number, binding)| match &binding.meaning {
                Meaning::Item(module) => vec![Place::Item { module: *module, name: name.into() }],
                Meaning::Module(child) => vec![Place::Module(*child)],
                Meaning::Import(path) => {
                    let import = (module, name.to_owned(), number);
                    guarded(followed, import, |followed| self.follow(module, path, followed))
                }
            });
            return Some(places.collect());
        }
        globs.iter().filter(visible).enumerate().find_map(|(number, glob)| {
            let Meaning::Import(path) = &glob.meaning else { return None };
            let import = (module, "*".to_owned(), number);
            let found = guarded(followed, import, |followed| {
                let places = self.follow(module, path, followed);
                let modules = places.iter().filter_map(Place::module);
                modules.filter_map(|from| self.look_up(from, name, module, followed)).flatten().collect()
            });
            (!found.is_empty()).then_some(found)
        })
    }

    /// Whether a module is the module `around` or inside it.
    fn is_within(&self, module: usize, around: usize) -> bool {
        let mut at = Some(module);
        while let Some(here) = at {
            if here == around {
                return true;
            }
            at = self.modules[here].parent;
        }
        false
    }
}

impl Place {
    /// The number of the module, if it is one.
    fn module(&self) -> Option<usize> {
        if let Self::Module(module) = self { Some(*module) } else { None }
    }
}

/// Resolves an import with `follow`, unless it is being resolved already.
fn guarded(
    followed: &mut Followed,
    import: (usize, String, usize),
    follow: impl FnOnce(&mut Followed) -> Vec<Place>,
) -> Vec<Place> {
    if followed.contains(&import) {
        return Vec::new();
    }
    followed.push(import);
    let places = follow(followed);
    followed.pop();
    places
}
