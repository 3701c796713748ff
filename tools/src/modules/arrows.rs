//! Comparing the dependencies between the crates with those in the document on the architecture.

use std::collections::BTreeMap;

use super::packages::Package;

/// The document that lists the dependencies in a block of arrows, as a path from the workspace root.
pub const DOCUMENT: &str = "docs/architecture.md";

/// The line before the arrows.
const BEGIN: &str = "```arrows\n";
/// Stands for no dependencies.
const NONE: &str = "(none)";
/// Marks dependencies of tests alone.
const TESTS: &str = "(tests)";

/// For each package the packages of this repository that it depends on, with `true` where only its tests do.
type Arrows = BTreeMap<String, BTreeMap<String, bool>>;

/// Compares the arrows in the text of the document with the packages' dependencies. Returns a line for each difference,
/// which says what to do.
pub fn differences(document: &str, packages: &[Package]) -> Vec<String> {
    let drawn = match read(document) {
        Ok(drawn) => drawn,
        Err(wrong) => return vec![wrong],
    };
    let mut found = Vec::new();
    for package in packages {
        let Some(allowed) = drawn.get(&package.name) else {
            let arrows = lines(&package.name, &package.dependencies).join("\n  ");
            found.push(format!("{}: has no arrow in {DOCUMENT}; add\n  {arrows}", package.name));
            continue;
        };
        let differs = |name: &String, tests: bool, other: &BTreeMap<String, bool>| other.get(name) != Some(&tests);
        let more = package.dependencies.iter().filter(|(name, tests)| differs(name, **tests, allowed));
        found.extend(more.map(|(name, tests)| {
            let tests = if *tests { " (tests)" } else { "" };
            format!(
                "{0}: depends on {name}{tests}; drop that from its Cargo.toml, or add the arrow `{0} -> {name}{tests}`",
                package.name
            )
        }));
        let less = allowed.iter().filter(|(name, tests)| differs(name, **tests, &package.dependencies));
        found.extend(less.map(|(name, tests)| {
            let tests = if *tests { " (tests)" } else { "" };
            format!("{0}: no longer depends on {name}{tests}; remove the arrow `{0} -> {name}{tests}`", package.name)
        }));
    }
    for name in drawn.keys().filter(|name| packages.iter().all(|package| package.name != **name)) {
        found.push(format!("{name}: no package of this name; remove its lines from {DOCUMENT}"));
    }
    found
}

/// The lines of the document for a package: one with its dependencies, and one with those of its tests, if any.
fn lines(name: &str, dependencies: &BTreeMap<String, bool>) -> Vec<String> {
    let of = |tests: bool| -> Vec<&str> {
        dependencies.iter().filter(|(_, only)| **only == tests).map(|(name, _)| name.as_str()).collect()
    };
    let (built, tests) = (of(false), of(true));
    let mut lines = vec![format!("{name} -> {}", if built.is_empty() { NONE.into() } else { built.join(" ") })];
    if !tests.is_empty() {
        lines.push(format!("{name} -> {} {TESTS}", tests.join(" ")));
    }
    lines
}

/// Reads the arrows from the text of the document: lines `crate -> crate crate`, `crate -> (none)` and `crate ->
/// crate (tests)`.
fn read(document: &str) -> Result<Arrows, String> {
    let block = document.split_once(BEGIN).and_then(|(_, rest)| rest.split_once("```"));
    let Some((block, _)) = block else { return Err(format!("{DOCUMENT}: has no block that begins with ```arrows")) };
    let mut arrows = Arrows::new();
    for line in block.lines().filter(|line| !line.trim().is_empty()) {
        let Some((name, to)) = line.split_once("->") else {
            return Err(format!(
                "{DOCUMENT}: not an arrow: `{line}`; write `crate -> crate crate` or `crate -> {NONE}`"
            ));
        };
        let (to, tests) = to.trim().strip_suffix(TESTS).map_or((to.trim(), false), |before| (before, true));
        let of = arrows.entry(name.trim().into()).or_default();
        of.extend(to.split_whitespace().filter(|name| *name != NONE).map(|name| (name.to_owned(), tests)));
    }
    Ok(arrows)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_DIFFERENCE: [String; 0] = [];

    #[test]
    fn differences_from_the_drawn_arrows_say_what_to_do() {
        let package = |name: &str, dependencies: &[(&str, bool)]| Package {
            name: name.into(),
            folder: "".into(),
            roots: Vec::new(),
            dependencies: dependencies.iter().map(|(name, tests)| ((*name).to_owned(), *tests)).collect(),
        };
        let packages = [package("core", &[]), package("net", &[("core", false), ("env", true)]), package("env", &[])];
        let with = |lines: &str| differences(&format!("# A\n```arrows\n{lines}\n```\n"), &packages);
        assert_eq!(with("core -> (none)\n\nnet -> core\nnet -> env (tests)\nenv -> (none)"), NO_DIFFERENCE);
        assert_eq!(
            with("core -> (none)\nnet -> core env\nenv -> core"),
            [
                "net: depends on env (tests); drop that from its Cargo.toml, or add the arrow `net -> env (tests)`",
                "net: no longer depends on env; remove the arrow `net -> env`",
                "env: no longer depends on core; remove the arrow `env -> core`"
            ]
        );
        assert_eq!(
            with("core -> (none)\nenv -> (none)\nold -> core"),
            [
                "net: has no arrow in docs/architecture.md; add\n  net -> core\n  net -> env (tests)",
                "old: no package of this name; remove its lines from docs/architecture.md"
            ]
        );
        assert_eq!(with("core").len(), 1);
        assert_eq!(differences("# A\n", &packages).len(), 1);
    }
}
