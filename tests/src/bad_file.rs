//! Files, folders and values that are not what a command expects.

use std::fs;
use std::path::{Path, PathBuf};

/// A file, or a place without one.
pub struct BadFile {
    /// What is wrong with it.
    pub kind: &'static str,
    /// Where it is.
    pub path: PathBuf,
    /// Whether a command may do with it nevertheless, as with a text that ends early.
    pub may_pass: bool,
}

/// In `folder`, files in place of a good one called `name`: none, a folder, one below a file, empty, cut off, of random
/// bytes, of another kind, in UTF-16, and those of `more`, which have names of their own kinds.
///
/// # Panics
/// When the folder takes no files.
#[must_use]
pub fn bad_files(folder: &Path, name: &str, good: &[u8], more: &[(&'static str, &[u8])]) -> Vec<BadFile> {
    let text = String::from_utf8_lossy(good);
    let wide: Vec<u8> = [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    // A linear congruence serves for bytes that mean nothing.
    let noise: Vec<u8> = (0..4096_u32).scan(7_u32, |x, _| Some(next(x))).collect();
    let picture = [&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], &noise[..600]].concat();
    let contents = [
        ("empty", &[][..]),
        ("cut off", &good[..good.len() / 2]),
        ("binary", &noise[..]),
        ("another kind", &picture[..]),
        ("UTF-16", &wide[..]),
    ];
    let place = |kind: &str| folder.join(kind.replace(' ', "-"));
    let mut found = Vec::new();
    for (kind, bytes) in contents.iter().chain(more) {
        fs::create_dir_all(place(kind)).expect("a folder");
        fs::write(place(kind).join(name), bytes).expect("written");
        let may_pass = matches!(*kind, "empty" | "cut off" | "UTF-16");
        found.push(BadFile { kind, path: place(kind).join(name), may_pass });
    }
    fs::create_dir_all(place("a folder").join(name)).expect("a folder");
    fs::write(place("below"), "").expect("written");
    for kind in ["missing", "a folder", "below"] {
        found.push(BadFile { kind, path: place(kind).join(name), may_pass: false });
    }
    found
}

fn next(x: &mut u32) -> u8 {
    *x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*x >> 24) as u8
}

/// Places where no file `name` can be made, by root neither: in a folder of the kernel, below a file, and where a
/// folder stands already.
///
/// # Panics
/// When `folder` takes no files.
#[must_use]
pub fn bad_places(folder: &Path, name: &str) -> Vec<(&'static str, PathBuf)> {
    let (file, taken) = (folder.join("a-file"), folder.join("taken").join(name));
    fs::create_dir_all(taken.join("kept")).expect("a folder");
    fs::write(&file, "kept").expect("written");
    let read_only = Path::new("/proc/covey").join(name);
    vec![("read-only", read_only), ("below a file", file.join(name)), ("a folder is there", taken)]
}

/// Values that no number of a command line may have.
#[must_use]
pub const fn bad_values() -> [&'static str; 7] {
    ["", "x", "NaN", "1e999", "-1e999", "99999999999999999999999999", "0x10"]
}
