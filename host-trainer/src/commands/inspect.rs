//! `inspect`: an actor file, checked and shown.

use super::actor::{load, read_actor};
use crate::cli::Inspect;
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
    println!("{name}: a sound actor, {} bytes", bytes.len());
    with_actor!(actor, actor => show(actor));
    Ok(())
}

fn show<O: ActorInput>(actor: &QuantisedActor<'_, O>) {
    let (d, p) = (actor.dimensions(), actor.provenance());
    let share = |c: u16| f64::from(c) / 10_000.0;
    println!("  observation    form {}", O::ID);
    println!("  aggregation    {}", actor.aggregation().name());
    println!("  widths         {} → {} → {} → {} → {}", d.observation, d.hidden, d.feature, d.head, d.actions);
    println!("  tie-breakers   drawn anew every {} step(s)", actor.tie_period());
    println!("  content hash   {:016x} (in messages {:08x})", actor.content_hash(), actor.message_hash());
    println!("  signature      {:016x}", fingerprint(actor, FINGERPRINT_CASES));
    println!("  self-test      passed");
    println!(
        "  trained by     {} on {}, {} UAVs, seed {}, {} episodes",
        p.trainer, p.scenario, p.uavs, p.seed, p.episodes
    );
    if p.worlds > 0 {
        println!(
            "  coverage       {:.4} as int8, {:.4} as float ({} held-out worlds)",
            share(p.int8_coverage),
            share(p.float_coverage),
            p.worlds
        );
    }
}
