//! Circles in small made-up packages.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::packages::Package;
use super::{circles, graph_of};

/// Writes files, given as paths and texts, into `folder`.
fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// The circles of a package with these files, of which the first is the root of its library.
fn found(files: &[(&str, &str)]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), files);
    let package = Package {
        name: "p".into(),
        folder: folder.path().into(),
        roots: vec![folder.path().join(files[0].0)],
        dependencies: BTreeMap::new(),
    };
    circles("p", &graph_of(&package).unwrap(), false)
}

const NONE: [String; 0] = [];

#[test]
fn two_files_that_use_each_other_are_a_circle() {
    let found = found(&[
        ("src/lib.rs", "mod a; mod b;"),
        ("src/a.rs", "use crate::b::B;\npub struct A(B);"),
        ("src/b.rs", "\nuse super::a::A;\npub struct B(Box<A>);"),
    ]);
    assert_eq!(found, ["p: src/a.rs -> src/b.rs (B, line 1) -> src/a.rs (A, line 2)"]);
}

#[test]
fn a_larger_circle_is_reported_by_its_shortest_part_and_its_number_of_files() {
    let three = [
        ("src/lib.rs", "mod a; mod b; mod c; mod d;"),
        ("src/a.rs", "pub fn a() { crate::b::b() }"),
        ("src/b.rs", "pub fn b() { crate::c::c() }"),
        ("src/c.rs", "pub fn c() { crate::a::a(); crate::d::d() }"),
        ("src/d.rs", "pub fn d() {}"),
    ];
    let circle = "p: src/a.rs -> src/b.rs (b, line 1) -> src/c.rs (c, line 1) -> src/a.rs (a, line 1)";
    assert_eq!(found(&three), [circle, "  3 files depend on each other in this circle"]);
    let mut four = three;
    four[4].1 = "pub fn d() { super::c::c() }";
    let circle = "p: src/c.rs -> src/d.rs (d, line 1) -> src/c.rs (c, line 1)";
    assert_eq!(found(&four), [circle, "  4 files depend on each other in this circle"]);
}

#[test]
fn a_parent_and_a_child_that_use_each_other_are_a_circle() {
    let root = ("src/lib.rs", "mod a;");
    let child = ("src/a/child.rs", "use super::A; pub fn f(_: A) {}");
    let circle = "p: src/a.rs -> src/a/child.rs (f, line 1) -> src/a.rs (A, line 1)";
    assert_eq!(found(&[root, ("src/a.rs", "mod child; pub struct A; fn g() { child::f(A) }"), child]), [circle]);
    let circle = "p: src/a/child.rs -> src/a/mod.rs (A, line 1) -> src/a/child.rs (f, line 1)";
    assert_eq!(found(&[root, ("src/a/mod.rs", "mod child; pub struct A; fn g() { child::f(A) }"), child]), [circle]);
    assert_eq!(found(&[root, ("src/a.rs", "mod child; pub struct A;"), child]), NONE);
}

#[test]
fn a_reexported_name_is_of_the_file_that_defines_it() {
    let files = |child: &'static str| {
        found(&[
            ("src/lib.rs", "mod a; pub use a::*;"),
            ("src/a/mod.rs", "mod one; mod two; pub use one::One; pub(crate) use two::*;"),
            ("src/a/one.rs", child),
            ("src/a/two.rs", "use super::One; pub struct Two(One);"),
        ])
    };
    assert_eq!(files("pub struct One;"), NONE);
    let circle = "p: src/a/one.rs -> src/a/two.rs (Two, line 1) -> src/a/one.rs (One, line 1)";
    assert_eq!(files("pub struct One(Box<super::Two>);"), [circle]);
    assert_eq!(files("use crate::Two as T; pub struct One(Box<T>);"), [circle]);
    assert_eq!(files("use crate::a::{self}; pub struct One(Box<a::Two>);"), [circle]);
}

#[test]
fn a_reexport_is_a_use_where_the_name_is_used_as_well() {
    let found = found(&[
        ("src/lib.rs", "mod a;"),
        ("src/a.rs", "mod child; pub use child::Child; pub struct A(Child);"),
        ("src/a/child.rs", "pub struct Child(Box<super::A>);"),
    ]);
    assert_eq!(found, ["p: src/a.rs -> src/a/child.rs (Child, line 1) -> src/a.rs (A, line 1)"]);
}

#[test]
fn nested_renamed_and_glob_imports_are_followed() {
    let with = |imports: &'static str| {
        found(&[
            ("src/lib.rs", "mod a; mod b;"),
            ("src/a.rs", "pub struct A; pub enum Kind { One } fn f() -> crate::b::B { todo!() }"),
            ("src/b.rs", imports),
        ])
    };
    let circle = |name: &str| vec![format!("p: src/a.rs -> src/b.rs (B, line 1) -> src/a.rs ({name}, line 1)")];
    assert_eq!(with("use {std::fmt, super::{a::{A as X}}}; pub struct B(X);"), circle("A"));
    assert_eq!(with("use crate::a as other; pub struct B(other::A);"), circle("A"));
    assert_eq!(with("use crate::a::*; pub struct B(A);"), circle("*"));
    assert_eq!(with("pub struct B; fn f() { use super::a::Kind::*; }"), circle("Kind"));
    assert_eq!(with("mod inner { pub fn f(_: super::super::a::A) {} } pub struct B;"), circle("A"));
}

#[test]
fn a_module_s_name_alone_is_no_use_and_neither_is_a_variable() {
    let found = found(&[
        ("src/lib.rs", "mod a;"),
        (
            "src/a.rs",
            "mod child; pub use child::width; pub struct A; fn f(width: u8, child: u8) -> u8 { width + child }",
        ),
        ("src/a/child.rs", "pub fn width(_: super::A) {}"),
    ]);
    assert_eq!(found, NONE);
}

#[test]
fn paths_in_macros_and_attributes_count() {
    let with = |body: &'static str| {
        found(&[
            ("src/lib.rs", "mod a; mod b;"),
            ("src/a.rs", "pub const A: u8 = crate::b::B; pub fn f() {}"),
            ("src/b.rs", body),
        ])
    };
    let circle = |name: &str| vec![format!("p: src/a.rs -> src/b.rs (B, line 1) -> src/a.rs ({name}, line 1)")];
    assert_eq!(with("pub const B: u8 = 1; fn f() { assert!(x.a, [crate::a::A]) }"), circle("A"));
    assert_eq!(with("use super::a; pub const B: u8 = 1; fn f() { println!(\"{}\", a::f()) }"), circle("f"));
    assert_eq!(with("pub const B: u8 = 1; #[arg(value_parser = super::a::f)] struct Args;"), circle("f"));
    assert_eq!(with("pub const B: u8 = 1; macro_rules! m { () => { $crate::a::A } }"), circle("A"));
    assert_eq!(with("pub const B: u8 = 1; fn f() { print!(\"{}\", x.a::<A>()) }"), NONE);
}

#[test]
fn a_macro_is_of_the_file_that_defines_it() {
    let found = found(&[
        ("src/lib.rs", "mod a;"),
        ("src/a.rs", "macro_rules! m { () => {} } mod child; fn f() { child::f() }"),
        ("src/a/child.rs", "pub fn f() { m!() }"),
    ]);
    assert_eq!(found, ["p: src/a.rs -> src/a/child.rs (f, line 1) -> src/a.rs (m, line 1)"]);
}

#[test]
fn an_exported_macro_is_of_the_file_that_defines_it() {
    let found = found(&[
        ("src/lib.rs", "mod a; mod b;"),
        ("src/a.rs", "#[macro_export] macro_rules! m { () => { $crate::b::B } }"),
        ("src/b.rs", "use crate::m; pub struct B; fn f() -> B { m!() }"),
    ]);
    assert_eq!(found, ["p: src/a.rs -> src/b.rs (B, line 1) -> src/a.rs (m, line 1)"]);
}

#[test]
fn what_only_tests_have_is_left_out() {
    let with = |child: &'static str| {
        found(&[
            ("src/lib.rs", "mod a; #[cfg(test)] mod tests;"),
            ("src/a.rs", "mod child; pub struct A; fn f() { child::f() }"),
            ("src/a/child.rs", child),
        ])
    };
    assert_eq!(with("pub fn f() {} #[cfg(test)] mod tests { use super::super::A; }"), NONE);
    assert_eq!(with("pub fn f() {} #[cfg(all(test, unix))] use super::A;"), NONE);
    assert_eq!(with("pub fn f() {} #[test] fn t() { super::A; }"), NONE);
    assert_eq!(with("pub fn f() {} #[cfg(any(test, unix))] use super::A;").len(), 1);
    assert_eq!(with("pub fn f() {} #[cfg(not(test))] use super::A;").len(), 1);
}

#[test]
fn modules_with_a_path_are_followed() {
    let found = found(&[
        ("src/lib.rs", "#[path = \"../far/b.rs\"] mod b; mod inner { #[path = \"c.rs\"] mod c; } pub struct A(b::B);"),
        ("far/b.rs", "mod beside; pub struct B; fn f(_: crate::A) { beside::f() }"),
        ("far/beside.rs", "pub fn f() {}"),
        ("src/inner/c.rs", ""),
    ]);
    assert_eq!(found, ["p: far/b.rs -> src/lib.rs (A, line 1) -> far/b.rs (B, line 1)"]);
}

#[test]
fn imports_that_lead_to_themselves_end() {
    let found = found(&[
        ("src/lib.rs", "mod a; mod b; use x::x; fn f(_: x::Y, _: Z) {}"),
        ("src/a.rs", "pub use super::b::*; pub use super::b::B;"),
        ("src/b.rs", "pub use super::a::*; pub use super::a::B; pub fn f(_: Z) {}"),
    ]);
    assert_eq!(found, NONE);
}
