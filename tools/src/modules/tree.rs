//! The modules of one target, the names in them, and where each name is defined.

use std::collections::HashMap;

use syn::Item;

/// The module tree of a library or a program. Modules are numbered, the root is 0.
#[derive(Default)]
pub struct Tree {
    /// The modules.
    pub modules: Vec<Module>,
}

/// A module: a file, or a part of one.
pub struct Module {
    /// The file that it is written in, as a path from the package's folder.
    pub file: String,
    /// Its items, without its child modules and without those that only tests have.
    pub items: Vec<Item>,
    /// The module around it; only the root has none.
    pub parent: Option<usize>,
    /// What the names in it mean; one name may be a type and a function, or depend on a `cfg`.
    pub names: HashMap<String, Vec<Binding>>,
    /// The paths of its imports of all names of another module.
    pub globs: Vec<Binding>,
}

/// What a name means.
#[derive(Clone, Debug)]
pub struct Binding {
    /// Whether it can be used outside the module, by a visibility of any kind.
    pub public: bool,
    /// What stands behind it.
    pub meaning: Meaning,
}

/// What stands behind a name.
#[derive(Clone, Debug)]
pub enum Meaning {
    /// A type, a function, a constant, a macro, written in the module of this number.
    Item(usize),
    /// The child module of this number.
    Module(usize),
    /// An import of this path.
    Import(Vec<String>),
}

/// Where a path leads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// To a module.
    Module(usize),
    /// To something that is defined in a module.
    Item {
        /// The module.
        module: usize,
        /// The name there.
        name: String,
    },
}

/// The imports being followed: one that leads to itself is not followed again.
type Followed = Vec<(usize, String, usize)>;

impl Tree {
    /// Where `path`, written in the module `from`, leads: nowhere where it is of another crate or a variable, to more
    /// than one place where a name means several things.
    pub fn resolve(&self, from: usize, path: &[String]) -> Vec<Place> {
        self.follow(from, path, &mut Followed::new())
    }

    /// Where a macro called `name` in the module `from` is defined: also before the `mod` of a module around it.
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
            // Another crate, a variable, a name of the standard library.
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
                // A macro may have written the name.
                found.unwrap_or_else(|| vec![Place::Item { module, name: name.clone() }])
            };
            places = modules.into_iter().flat_map(inside).collect();
        }
        places
    }

    /// What `name` means in a module, seen from another; nothing where the module does not have it.
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
    fn module(&self) -> Option<usize> {
        if let Self::Module(module) = self { Some(*module) } else { None }
    }
}

/// Follows an import unless that is what is being done already.
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
