//! `eval`: policies on held-out worlds.

use super::actor::{load, read, read_actor};
use super::pil::Emulated;
use super::threads::use_threads;
use crate::cli::Eval;
use crate::commands::hold::Hold;
use crate::commands::interrupt::Stop;
use crate::commands::meter::Meter;
use crate::commands::output::{print_out, say_out};
use crate::eval::{
    AnyActor, EvalConfig, EvalPolicy, EvalRow, PilFigures, Watch, argmax_agreement, evaluate_with_radio, radio_table,
    table, with_actor,
};
use crate::float_actor::FloatActor;
use crate::run::RunFolder;
use covey_env::Scenario;
use miette::{IntoDiagnostic, Result, WrapErr, miette};

/// Measures and prints.
///
/// # Errors
/// When the policy cannot be read or the worlds not be built.
pub fn run(args: &Eval) -> Result<()> {
    if args.worlds < 2 {
        return Err(miette!("--worlds {}: a standard error needs at least 2 worlds", args.worlds));
    }
    let stop = Stop::with_words("stopped measuring; nothing was written, the same command begins again".into())?;
    use_threads(args.threads);
    let (bytes, name) = match (&args.model, &args.run) {
        (_, Some(run)) => {
            let file = RunFolder::open(run).into_diagnostic()?.actor();
            let bytes = read(&file).wrap_err("the run has no actor file yet; make one with `host-trainer export`")?;
            (bytes, file.display().to_string())
        }
        (model, _) => read_actor(model.as_deref())?,
    };
    let mut worlds = Scenario::default();
    let mut float = None;
    if let Some(run) = &args.run {
        // Worlds as the run has them, but for what the flags say.
        let folder = RunFolder::open(run).into_diagnostic()?;
        worlds = folder.settings().into_diagnostic()?.world();
        if args.float {
            let (settings, checkpoint) = folder.load().into_diagnostic()?;
            float = Some(FloatActor::new(&settings, checkpoint.state.average));
        }
    }
    let board = Emulated::find(args.actor, args.image.as_deref())?;
    let config = |uavs| {
        let worlds = if args.same_density { with_density_of(&worlds, uavs) } else { worlds.clone() };
        let scenario = Scenario { uavs: usize::from(uavs), distribution: args.poi_distribution, ..worlds };
        EvalConfig { scenario, seed: args.seed, worlds: args.worlds, mode: args.decide }
    };
    let configs: Vec<_> = args.uavs.iter().map(|&uavs| config(uavs)).collect();
    // Every radio flies the worlds, and a float policy does, then both are compared in them.
    let times = if args.float { 3 } else { args.radio.len().max(1) as u64 };
    let agent_steps = times * configs.iter().map(EvalConfig::agent_steps).sum::<u64>();
    let (mut rows, mut difference) = (Vec::new(), None);
    Hold::before_measuring()?;
    // Boards tell themselves how far they are.
    let meter = Meter::new(board.is_some(), agent_steps);
    for config in configs {
        match &board {
            None => rows.extend(evaluate_one(args, (&bytes, &name), float.as_ref(), &config, &meter)?),
            Some(board) => {
                let AnyActor::Compact(actor) = load(&bytes, &name)? else {
                    return Err(miette!(
                        "{name} observes cells, and the flight program builds the compact observation alone: leave --actor out"
                    ));
                };
                let policy = format!("{} int8", actor.aggregation().name());
                let (row, first) = board.evaluate(&policy, &bytes, &actor, &config, &stop)?;
                rows.push(row);
                difference = difference.or(first);
            }
        }
    }
    drop(meter);
    if args.json {
        say_out!("{}", serde_json::to_string_pretty(&rows).into_diagnostic()?)?;
    } else {
        print_out!("{}", table(&rows))?;
        let radios: Vec<_> = rows.iter().filter_map(|row| row.radio.clone()).collect();
        if !radios.is_empty() {
            print_out!("\n{}", radio_table(&radios))?;
        }
        for (row, board) in rows.iter().filter_map(|row| Some((row, row.board.as_ref()?))) {
            let PilFigures { actor, decisions, differences } = board;
            say_out!("{actor}, {} UAVs: {decisions} decisions, {differences} differences", row.uavs)?;
        }
    }
    difference.map_or(Ok(()), |first| {
        Err(miette!(
            help = "build the flight program anew: `cargo xtask targets`",
            "the board decides otherwise than this computer, first: {first}"
        ))
    })
}

/// Worlds for this number of UAVs with as many of them, and of PoIs, to the area as in `base`.
fn with_density_of(base: &Scenario, uavs: u16) -> Scenario {
    let times = f64::from(uavs) / base.uavs as f64;
    Scenario {
        uavs: uavs.into(),
        pois: ((base.pois as f64 * times).round() as usize).max(1),
        side_u: (f64::from(base.side_u) * times.sqrt()) as f32,
        ..base.clone()
    }
}

/// The rows for one number of UAVs; `file` is the actor file's bytes and its name.
fn evaluate_one(
    args: &Eval,
    file: (&[u8], &str),
    float: Option<&FloatActor>,
    config: &EvalConfig,
    meter: &Meter,
) -> Result<Vec<EvalRow>> {
    let watch: Watch<'_> = &|agent_steps| meter.add(agent_steps);
    if let Some(policy) = args.policy {
        return Ok(vec![
            EvalPolicy::Reference(policy).evaluate_watched(policy.name(), config, watch).into_diagnostic()?,
        ]);
    }
    let actor = load(file.0, file.1)?;
    let name = actor.aggregation().name();
    let policy = format!("{name} int8");
    if !args.radio.is_empty() {
        let over = |radio| with_actor!(actor, actor => evaluate_with_radio(actor, &policy, config, radio, watch));
        let rows = args.radio.iter().map(|radio| over(radio).map(|(row, _)| row));
        return rows.collect::<Result<_, _>>().into_diagnostic();
    }
    let mut rows = vec![EvalPolicy::of(&actor).evaluate_watched(&policy, config, watch).into_diagnostic()?];
    if let Some(float) = float {
        rows.push(
            EvalPolicy::Float(float).evaluate_watched(&format!("{name} float"), config, watch).into_diagnostic()?,
        );
        let agreement = with_actor!(actor, actor => argmax_agreement(actor, float, config, watch)).into_diagnostic()?;
        meter.say(&format!(
            "argmax agreement {:.2} % over {} decisions",
            100.0 * agreement.share(),
            agreement.decisions
        ));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_grows_with_the_swarm() {
        let base = Scenario::default();
        assert_eq!(with_density_of(&base, 20), base);
        let large = with_density_of(&base, 2000);
        assert_eq!((large.uavs, large.pois, large.side_u), (2000, 12_000, 2000.0));
        assert_eq!(large.validate(), Ok(()));
        assert_eq!(with_density_of(&base, 16_384).validate(), Ok(()));
        assert_eq!(with_density_of(&base, 5).pois, 30);
    }
}
