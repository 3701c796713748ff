//! Tables in Markdown documents that commands of `cargo xtask` write.

use std::fs;

use crate::error::{Error, Result};
use crate::workspace;

/// The comment after a table.
const END: &str = "<!-- end of table -->\n";

/// Replaces the table of `cargo xtask {task} --bless` in `document`, a path from the workspace root. The table stands
/// between two comments, which stay.
///
/// # Errors
/// The document cannot be read or written, or the comments are missing.
pub fn replace_table(document: &str, task: &str, table: &str) -> Result<()> {
    let path = workspace::root().join(document);
    let text = fs::read_to_string(&path).map_err(Error::file(&path))?;
    let text = replaced(&text, task, table).ok_or_else(|| {
        Error::content(&path, format!("the comments around the table of `cargo xtask {task}` are missing"))
    })?;
    fs::write(&path, text).map_err(Error::file(&path))
}

/// The text of a document with another table; `None` where the comments around the table are missing.
fn replaced(text: &str, task: &str, table: &str) -> Option<String> {
    let begin = format!("<!-- table: written by `cargo xtask {task} --bless` -->\n");
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{begin}{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_stands_between_the_comments_changes() {
        let text = |table| {
            format!("a\n<!-- table: written by `cargo xtask counts --bless` -->\n{table}<!-- end of table -->\nb\n")
        };
        assert_eq!(replaced(&text("old\n"), "counts", "new\n"), Some(text("new\n")));
        assert_eq!(replaced(&text("old\n"), "targets", "new\n"), None);
    }
}
