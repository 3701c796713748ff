//! Finding paths among the tokens of a macro call or an attribute, whose grammar is not known.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// A path among tokens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The names of the path.
    pub path: Vec<String>,
    /// The line of the first name, from 1.
    pub line: usize,
    /// Whether the path is called.
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

/// All paths in `tokens`, also inside brackets. Fields, methods and lifetimes are left out.
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

/// The path that begins at the name `start`, and the position after it.
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

/// Whether a token is this punctuation character.
fn is_punct(token: Option<&TokenTree>, sign: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == sign)
}

/// Whether the tokens before a name make it a field, a method, a lifetime, or the rest of a path that began earlier.
fn is_no_path(before: &[TokenTree]) -> bool {
    match before {
        [.., TokenTree::Punct(first), TokenTree::Punct(second)] => {
            let joint = first.spacing() == Spacing::Joint && first.as_char() == second.as_char();
            // After `..` a new expression begins, after `::` a path goes on.
            if joint { second.as_char() == ':' } else { matches!(second.as_char(), '.' | '\'') }
        }
        [.., TokenTree::Punct(last)] => matches!(last.as_char(), '.' | '\''),
        _ => false,
    }
}
