//! `report`: pages from run folders.

use crate::cli::Report;
use crate::commands::hold::Hold;
use crate::commands::interrupt::Stop;
use crate::commands::output::say_out;
use crate::run::{RunFolder, report};
use miette::{IntoDiagnostic, Result};
use std::path::PathBuf;

/// Writes the page.
///
/// # Errors
/// When a run cannot be read or the page not be written.
pub fn run(args: &Report) -> Result<()> {
    let _stop = Stop::with_words("stopped; the page was not written, every file is whole".into())?;
    let folders = args.runs.iter().map(|r| RunFolder::open(r).into_diagnostic()).collect::<Result<Vec<_>>>()?;
    Hold::before_measuring()?;
    let path = match &folders[..] {
        [one] => {
            if let Some(path) = &args.out {
                report::page(one)?.write(path).into_diagnostic()?;
                path.clone()
            } else {
                report::write(one)?
            }
        }
        many => {
            let page = report::compare(many)?;
            let path = args.out.clone().unwrap_or_else(|| PathBuf::from("compare.html"));
            page.write(&path).into_diagnostic()?;
            path
        }
    };
    say_out!("wrote {}", path.display())?;
    Ok(())
}
