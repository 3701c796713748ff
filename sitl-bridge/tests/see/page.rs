//! The page of a simulated flight, in a real browser.

use crate::sim::{bridge, python, words};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The browser: what CHROMIUM names, else the first of the usual names on the PATH.
fn chromium() -> PathBuf {
    if let Some(path) = std::env::var_os("CHROMIUM") {
        return path.into();
    }
    let folders: Vec<_> = std::env::var_os("PATH").map(|p| std::env::split_paths(&p).collect()).unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.iter().flat_map(|name| folders.iter().map(move |f| f.join(name))).find(|p| p.is_file());
    found.expect("no Chromium, which looks at the page: `cargo xtask test` installs it, or CHROMIUM names one")
}

/// The page's document after its scripts ran.
fn document(page: &Path, settings: &str) -> String {
    let profile = tempfile::tempdir().expect("a temporary folder");
    let output = Command::new(chromium())
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--virtual-time-budget=4000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}#{settings}", page.display()))
        .output()
        .expect("Chromium starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Value of an attribute of the document's root, where the page tells its state.
fn state<'a>(document: &'a str, name: &str) -> &'a str {
    let root = &document[document.find("<html").expect("a root")..];
    let root = &root[..root.find('>').expect("a whole root")];
    let value = root.split(&format!("data-{name}=\"")).nth(1).unwrap_or_else(|| panic!("no data-{name} in {root}"));
    value.split('"').next().expect("a value")
}

#[test]
fn the_page_plays_the_flight_beside_the_trainers() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("new").join("out.html");
    let (file, python) = (page.to_str().unwrap(), python());
    // With the scenario's own dynamics the flight is the trainer's.
    let args = ["swarm", "--sim", "--ideal", "--count", "4", "--steps", "8", "--pois", "30", "--worlds", "2"];
    let output = bridge(&[&args[..], &["--json", "--report", file, "--python", python.to_str().unwrap()]].concat());
    assert!(output.status.success() && words(&output).contains("out.html plays the flights"), "{}", words(&output));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(summary["worlds"], 2);
    // World 1, flown and the trainer's.
    let [flown, trained] = ["episode=3&step=8", "episode=4&step=8"].map(|settings| {
        let document = document(&page, settings);
        assert_eq!((state(&document, "errors"), state(&document, "ready")), ("0", "1"));
        assert_eq!(state(&document, "step"), "8");
        assert!(!document.contains("NaN"), "a number went missing");
        // Two worlds and their mean, flown and the trainer's.
        assert!(document.matches("class=\"line s").count() >= 6, "curves");
        state(&document, "coverage").to_owned()
    });
    assert_eq!(flown, trained);
    assert!(flown.ends_with("of 30"), "{flown}");
}
