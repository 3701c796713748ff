//! Recognising items that are compiled for tests only.

use syn::punctuated::Punctuated;
use syn::{Attribute, Item, Meta, Token};

/// Whether an item with these attributes is compiled for tests only: with `#[test]`, or with a `#[cfg]` that implies
/// `test`.
pub fn is_test_only(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let path = attribute.path();
        path.is_ident("test") || path.is_ident("cfg") && attribute.parse_args().is_ok_and(|meta| implies_test(&meta))
    })
}

/// Whether a condition can only be true if `test` is.
fn implies_test(condition: &Meta) -> bool {
    let all_of = |of: fn(&[Meta]) -> bool| match condition {
        Meta::List(list) => list
            .parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated)
            .is_ok_and(|inner| of(&inner.into_iter().collect::<Vec<_>>())),
        _ => false,
    };
    let path = condition.path();
    path.is_ident("test")
        || path.is_ident("all") && all_of(|inner| inner.iter().any(implies_test))
        || path.is_ident("any") && all_of(|inner| !inner.is_empty() && inner.iter().all(implies_test))
}

/// The attributes of an item.
pub fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
