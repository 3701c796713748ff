//! Writes a report of made-up data, for those who change the page:
//! `cargo run -p covey-report --example demo -- demo` and open `demo/report.html`.

mod world;

use std::path::PathBuf;

use covey_report::atomic;
use covey_report::report::{Content, ReportError, chart_svg, episode_svg};

fn main() -> Result<(), ReportError> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "demo".into()));
    let report = world::report();
    report.write(folder.join("report.html"))?;
    for section in &report.sections {
        match &section.content {
            Content::Episodes(e) => atomic::write(folder.join("episode.svg"), episode_svg(&e[0], 70)?.as_bytes())?,
            Content::Charts(c) => atomic::write(folder.join("chart.svg"), chart_svg(&c[0])?.as_bytes())?,
            _ => {}
        }
    }
    println!("{}", folder.join("report.html").display());
    Ok(())
}
