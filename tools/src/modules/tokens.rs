//! Paths in the tokens of a macro call, which nobody but the macro can parse.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// A path among tokens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its names.
    pub path: Vec<String>,
    /// The line of its first name, from 1.
    pub line: usize,
    /// What follows it.
    pub call: Call,
}

/// Whether a path is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// Not called.
    No,
    /// `name(…)`.
    Function,
    /// `name!(…)`, with any brackets.
    Macro,
}

/// All paths in `tokens` and in the groups inside. Names after a dot are fields or methods, after a quote lifetimes.
pub fn paths(tokens: TokenStream) -> Vec<Found> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        match token {
            TokenTree::Group(group) => found.extend(paths(group.stream())),
            TokenTree::Ident(_) if !is_no_path(tokens.get(..at).unwrap_or_default()) => {
                let (path, end) = path_at(&tokens, at);
                found.push(path);
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// The path that begins at a name, and where it ends.
fn path_at(tokens: &[TokenTree], start: usize) -> (Found, usize) {
    let mut names = Vec::new();
    let mut at = start;
    while let Some(TokenTree::Ident(name)) = tokens.get(at) {
        names.push(name.to_string());
        at += 1;
        let colons = [tokens.get(at), tokens.get(at + 1)];
        let followed = matches!(tokens.get(at + 2), Some(TokenTree::Ident(_)));
        if !followed || !colons.iter().all(|token| is_punct(*token, ':')) {
            break;
        }
        at += 2;
    }
    let call = match tokens.get(at) {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis => Call::Function,
        token if is_punct(token, '!') && matches!(tokens.get(at + 1), Some(TokenTree::Group(_))) => Call::Macro,
        _ => Call::No,
    };
    let line = tokens.get(start).map_or(0, |token| token.span().start().line);
    (Found { path: names, line, call }, at)
}

fn is_punct(token: Option<&TokenTree>, sign: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == sign)
}

/// Whether what stands before a name makes it a field, a method, a lifetime, or a part of another crate's path.
fn is_no_path(before: &[TokenTree]) -> bool {
    match before {
        [.., TokenTree::Punct(first), TokenTree::Punct(second)] => {
            let joint = first.spacing() == Spacing::Joint && first.as_char() == second.as_char();
            // `..` is a range, `::` the rest of a path.
            if joint { second.as_char() == ':' } else { matches!(second.as_char(), '.' | '\'') }
        }
        [.., TokenTree::Punct(last)] => matches!(last.as_char(), '.' | '\''),
        _ => false,
    }
}
