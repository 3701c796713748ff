//! Files as users have them: missions of many tools and makes, recordings whole and broken, and any bytes at all.

mod abuse;
mod cases;
mod convert;
mod formats;
mod fuzz;
mod geojson;
mod recordings;
mod toml;

use sitl_bridge::mission::{Loaded, Mission};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Reads bytes as a mission file of this name.
fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<Loaded, String> {
    Loaded::from_bytes(bytes.as_ref(), Path::new(name)).map_err(|error| error.to_string())
}

/// The mission and all remarks, one a line.
fn loaded(name: &str, bytes: impl AsRef<[u8]>) -> (Mission, String) {
    let loaded = load(name, bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    (loaded.mission, loaded.remarks.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// What is said of a file that is refused.
fn refused(name: &str, bytes: impl AsRef<[u8]>) -> String {
    match load(name, bytes) {
        Err(error) => error,
        Ok(loaded) => panic!("{name} was read: {loaded:?}"),
    }
}

fn utf16(text: &str, big: bool, mark: bool) -> Vec<u8> {
    let units = mark.then_some(0xFEFF).into_iter().chain(text.encode_utf16());
    units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
}

fn bridge(args: &[&std::ffi::OsStr]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sitl-bridge")).args(args).stdin(Stdio::null()).output().expect("it runs")
}

/// What a command says on its standard error, in one line: the report breaks lines and marks them.
fn words(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '╰', '├', '─', '▶', '×'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
