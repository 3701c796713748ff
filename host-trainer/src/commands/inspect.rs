//! `inspect`: an actor file, checked and shown.

use super::actor::{load, read_actor};
use crate::cli::Inspect;
use crate::commands::output::say_out;
use crate::eval::with_actor;
use firmware_core::actor::{ActorInput, FINGERPRINT_CASES, QuantisedActor, fingerprint};
use miette::Result;

/// Loads the file, runs its self-test and prints what is in it.
///
/// # Errors
/// When the file is not a sound actor.
pub fn run(args: &Inspect) -> Result<()> {
    let (bytes, name) = read_actor(Some(&args.file))?;
    let actor = load(&bytes, &name)?;
    say_out!("{name}: a sound actor, {} bytes", bytes.len())?;
    with_actor!(actor, actor => show(actor))
}

fn show<O: ActorInput>(actor: &QuantisedActor<'_, O>) -> Result<()> {
    let (d, p) = (actor.dimensions(), actor.provenance());
    let share = |c: u16| f64::from(c) / 10_000.0;
    say_out!("  observation    form {}", O::ID)?;
    say_out!("  aggregation    {}", actor.aggregation().name())?;
    say_out!("  widths         {} → {} → {} → {} → {}", d.observation, d.hidden, d.feature, d.head, d.actions)?;
    say_out!("  tie-breakers   drawn anew every {} step(s)", actor.tie_period())?;
    say_out!("  content hash   {:016x} (in messages {:08x})", actor.content_hash(), actor.message_hash())?;
    say_out!("  signature      {:016x}", fingerprint(actor, FINGERPRINT_CASES))?;
    say_out!("  self-test      passed")?;
    say_out!(
        "  trained by     {} on {}, {} UAVs, seed {}, {} episodes",
        p.trainer,
        p.scenario,
        p.uavs,
        p.seed,
        p.episodes
    )?;
    if p.worlds > 0 {
        say_out!(
            "  coverage       {:.4} as int8, {:.4} as float ({} held-out worlds)",
            share(p.int8_coverage),
            share(p.float_coverage),
            p.worlds
        )?;
    }
    Ok(())
}
