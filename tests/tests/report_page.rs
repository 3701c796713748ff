//! The report page in a real browser: it runs without errors, plays, and is not blank.

#[path = "../../host-trainer/report/examples/demo/world.rs"]
mod world;

use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Time the page is given to run, as it sees it, ms.
const BUDGET_MS: u32 = 4000;

/// The browser: what CHROMIUM names, else the first of the usual names on the PATH.
fn chromium() -> PathBuf {
    if let Some(path) = std::env::var_os("CHROMIUM") {
        return path.into();
    }
    let folders: Vec<_> = std::env::var_os("PATH").map(|p| std::env::split_paths(&p).collect()).unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.iter().flat_map(|name| folders.iter().map(move |f| f.join(name))).find(|p| p.is_file());
    found.expect(
        "no Chromium found, which this test needs to look at the report page. Install it with \
         `sudo apt-get install chromium` (`cargo xtask test` does so), or name it in the variable CHROMIUM",
    )
}

/// A report in a folder of its own, to be opened again and again.
struct Page {
    folder: TempDir,
}

impl Page {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        world::report().write(folder.path().join("report.html")).expect("a report");
        Self { folder }
    }

    /// The state after `script` ran in a page that holds the report as `page` (its
    /// window) in a frame of the given width; `tell(name, value)` adds to the state.
    fn drive(&self, width: u32, script: &str) -> String {
        let html = format!(
            "<!doctype html><html><body><iframe src='report.html' width={width} height=800></iframe><script>\
             const tell = (name, value) => {{ document.documentElement.dataset[name] = value; }};\
             onload = () => {{ const page = frames[0]; {script} }};</script></body></html>"
        );
        std::fs::write(self.folder.path().join("drive.html"), html).expect("a page");
        self.open("drive.html", &["--dump-dom", "--allow-file-access-from-files"])
    }

    /// Runs Chromium on a page of the folder; returns its output.
    fn open(&self, page: &str, arguments: &[&str]) -> String {
        let profile = tempfile::tempdir().expect("a temporary folder");
        let output = Command::new(chromium())
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-quic",
                "--no-first-run",
                "--disable-dev-shm-usage",
            ])
            .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
            .args(["--hide-scrollbars", &format!("--virtual-time-budget={BUDGET_MS}")])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .args(arguments)
            .arg(format!("file://{}/{page}", self.folder.path().display()))
            .output()
            .expect("Chromium starts");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "Chromium failed ({}):\n{errors}", output.status);
        String::from_utf8(output.stdout).expect("text")
    }

    /// The document after its scripts ran.
    fn document(&self, settings: &str) -> String {
        self.open(&format!("report.html#{settings}"), &["--dump-dom"])
    }

    fn picture(&self, settings: &str, (width, height): (u32, u32)) -> Picture {
        let path = self.folder.path().join("page.png");
        let arguments = [format!("--screenshot={}", path.display()), format!("--window-size={width},{height}")];
        self.open(&format!("report.html#{settings}"), &arguments.each_ref().map(String::as_str));
        Picture::read(&path)
    }
}

/// Value of an attribute of the document's root, where the page tells its state.
fn state<'a>(document: &'a str, name: &str) -> &'a str {
    let root = &document[document.find("<html").expect("a root")..];
    let root = &root[..root.find('>').expect("a whole root")];
    let value = root.split(&format!("data-{name}=\"")).nth(1).unwrap_or_else(|| panic!("no data-{name} in {root}"));
    value.split('"').next().expect("a value")
}

struct Picture {
    width: usize,
    /// Red, green, blue of each pixel.
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let file = BufReader::new(File::open(path).expect("a screenshot"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut bytes).expect("pixels");
        let channels = info.color_type.samples();
        let pixels = bytes[..info.buffer_size()].chunks_exact(channels).map(|p| [p[0], p[1], p[2]]).collect();
        Self { width: info.width as usize, pixels }
    }

    fn colours(&self) -> usize {
        self.pixels.iter().collect::<HashSet<_>>().len()
    }

    /// Mean of all channels, 0 to 255.
    fn brightness(&self) -> f64 {
        let sum: u64 = self.pixels.iter().flatten().map(|c| u64::from(*c)).sum();
        sum as f64 / (3 * self.pixels.len()) as f64
    }
}

#[test]
fn the_page_runs_without_errors_and_shows_its_curves() {
    let document = Page::new().document("step=40");
    assert_eq!(state(&document, "errors"), "0");
    assert_eq!(state(&document, "ready"), "1");
    assert_eq!((state(&document, "step"), state(&document, "playing")), ("40", "0"));
    // Nine charts of three curves each, with bands, and the player's own.
    assert!(document.matches("class=\"line s").count() >= 27, "curves");
    assert_eq!(document.matches("class=\"band s").count(), 27);
    assert!(!document.contains("NaN"), "a number went missing");

    let frame = &world::episode("", 10, 100).frames[40];
    let covered = frame.covered.iter().filter(|c| **c).count();
    let shown = format!("{:.1} % {covered} of 120", frame.coverage * 100.0);
    assert_eq!(state(&document, "coverage"), shown);
}

#[test]
fn the_player_starts_by_itself_when_it_is_asked_to() {
    let document = Page::new().document("play");
    assert_eq!((state(&document, "errors"), state(&document, "playing")), ("0", "1"));
}

/// The frames of the screen are dealt out by hand, so that time is exact.
#[test]
fn playing_moves_the_chosen_number_of_steps_a_second_and_stops_at_the_end() {
    let driven = Page::new().drive(
        1000,
        r#"
        const state = page.document.documentElement.dataset;
        let queue = [];
        page.requestAnimationFrame = (frame) => queue.push(frame);
        const run = (from, to) => { for (let t = from; t <= to; t += 50) queue.splice(0).forEach((frame) => frame(t)); };
        page.document.querySelector('[data-do="play"]').click();
        run(0, 1000); tell('second', state.step); tell('playing', state.playing);
        run(1050, 11000); tell('end', state.step); tell('stopped', state.playing);
        page.document.querySelector('[data-do="play"]').click();
        run(20000, 20500); tell('again', state.step);
        tell('errors', state.errors);
        "#,
    );
    let expected =
        [("second", "10"), ("playing", "1"), ("end", "100"), ("stopped", "0"), ("again", "5"), ("errors", "0")];
    for (name, value) in expected {
        assert_eq!(state(&driven, name), value, "{name}");
    }
}

#[test]
fn keys_move_the_player_and_names_hide_their_curves() {
    let driven = Page::new().drive(
        1000,
        r#"
        const state = page.document.documentElement.dataset;
        const key = (key, shiftKey) => page.document.querySelector('[data-player]')
            .dispatchEvent(new page.KeyboardEvent('keydown', { key, shiftKey, bubbles: true, cancelable: true }));
        key('ArrowRight'); key('ArrowRight', true); tell('right', state.step);
        key('ArrowLeft'); tell('left', state.step);
        key('End'); key('ArrowRight'); tell('end', state.step);
        key('Home'); tell('home', state.step);
        key('u'); key('+'); key(' '); tell('space', state.playing);
        key(' '); tell('again', state.playing);
        page.document.querySelectorAll('[data-episode]')[1].click();
        page.document.querySelector('[data-toggle="1"]').click();
        tell('hidden', page.document.querySelectorAll('.line.off[data-series="1"]').length);
        tell('errors', state.errors);
        "#,
    );
    let expected = [
        ("right", "11"),
        ("left", "10"),
        ("end", "100"),
        ("home", "0"),
        ("space", "1"),
        ("again", "0"),
        ("hidden", "9"),
        ("errors", "0"),
    ];
    for (name, value) in expected {
        assert_eq!(state(&driven, name), value, "{name}");
    }
}

#[test]
fn nothing_is_wider_than_the_screen() {
    let page = Page::new();
    for width in [320, 390, 768, 1280] {
        let driven = page.drive(width, "tell('wide', page.document.documentElement.scrollWidth - page.innerWidth);");
        let wide: i32 = state(&driven, "wide").parse().expect("a number");
        assert!(wide <= 0, "{wide} pixels too wide at {width}");
    }
}

#[test]
fn settings_that_make_no_sense_are_harmless() {
    for settings in ["step=999&episode=7&uav=500&theme=pink", "step=x&uav=-1&episode=0", "%%%", "section-2"] {
        let document = Page::new().document(settings);
        assert_eq!((state(&document, "errors"), state(&document, "ready")), ("0", "1"), "{settings}");
    }
}

#[test]
fn the_page_is_not_blank_on_a_desktop_or_a_phone_in_light_or_dark() {
    let page = Page::new();
    for size in [(1280, 1400), (500, 2400)] {
        let light = page.picture("step=40&theme=light&uav=3", size);
        let dark = page.picture("step=40&theme=dark&uav=3", size);
        for picture in [&light, &dark] {
            assert_eq!((picture.width, picture.pixels.len()), (size.0 as usize, (size.0 * size.1) as usize));
            assert!(picture.colours() > 100, "{} colours at {size:?}", picture.colours());
        }
        assert!(light.brightness() > 200.0 && dark.brightness() < 60.0, "themes at {size:?}");
    }
}
