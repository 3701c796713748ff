//! Checking that the files named in the document on the architecture exist.

use std::path::Path;

use super::arrows::DOCUMENT;

/// Returns a line for each file or folder between backticks in the text of the document that is not there. What has a
/// slash in it and no blank is taken for a path from the workspace root.
pub fn missing(document: &str, root: &Path) -> Vec<String> {
    let quoted = document.split('`').skip(1).step_by(2);
    let paths = quoted.filter(|text| text.contains('/') && !text.contains(char::is_whitespace));
    let gone = paths.filter(|path| !root.join(path).exists());
    gone.map(|path| format!("{DOCUMENT}: names {path}, which does not exist; write where it is now")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_is_gone_is_named() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(root.path().join("a/src")).unwrap();
        std::fs::write(root.path().join("a/src/b.rs"), "").unwrap();
        let text = "`a/src/b.rs` and `a/src/`, not `a/src/c.rs`; `b.rs` is no path, `a / b` neither";
        assert_eq!(
            missing(text, root.path()),
            ["docs/architecture.md: names a/src/c.rs, which does not exist; write where it is now"]
        );
    }
}
