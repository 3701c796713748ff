//! `export`: from a run's newest checkpoint to an actor file.

use crate::cli::Export;
use crate::commands::hold::Hold;
use crate::commands::interrupt::Stop;
use crate::commands::meter::Meter;
use crate::commands::output::say_out;
use crate::export::{export_actor_watched, export_agent_steps};
use crate::run::RunFolder;
use covey_report::atomic;
use miette::{IntoDiagnostic, Result};

/// Quantises and writes.
///
/// # Errors
/// When the run cannot be read or the file not be written.
pub fn run(args: &Export) -> Result<()> {
    let parting = format!("stopped while quantising and measuring; {} was not written", args.out.display());
    let _stop = Stop::with_words(parting)?;
    let folder = RunFolder::open(&args.run).into_diagnostic()?;
    let (mut settings, checkpoint) = folder.load().into_diagnostic()?;
    if let Some(t) = args.temperature {
        settings.temperature = t;
        settings.validate().into_diagnostic()?;
    }
    Hold::before_measuring()?;
    let done = {
        let meter = Meter::new(false, export_agent_steps(&settings));
        export_actor_watched(&settings, &checkpoint.state, &|agent_steps| meter.add(agent_steps)).into_diagnostic()?
    };
    atomic::write(&args.out, &done.file).into_diagnostic()?;
    say_out!(
        "wrote {} ({} bytes): coverage {:.4} as int8, {:.4} as float, argmax agreement {:.2} %",
        args.out.display(),
        done.file.len(),
        done.int8.coverage,
        done.float.coverage,
        100.0 * done.agreement.share()
    )?;
    say_out!("next: host-trainer inspect {}", args.out.display())?;
    Ok(())
}
