//! `bench`: how fast this machine plays and learns, and how near that is to what it could.

use super::against::{Turns, take_turns};
use super::machine::{memory_gb_per_s, peak_gflops, peak_memory_mib};
use super::{apply, cores, use_threads};
use crate::cli::{Bench, StageArg};
use crate::settings::{Graph, Settings};
use crate::train::{Stage, Trainer, Workers, dimensions};
use covey_env::ObservationForm;
use miette::{IntoDiagnostic, Result, miette};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Least time of a measurement beside another program.
const TURN: Duration = Duration::from_secs(4);

/// What `bench --json` prints. Rates are medians over the repeats, agent-steps per second.
#[derive(Serialize)]
struct Report {
    env_agent_steps_per_s: f64,
    policy_agent_steps_per_s: f64,
    update_agent_steps_per_s: f64,
    train_agent_steps_per_s: f64,
    /// Multiply-adds of the update an agent-step, those with a zero left out.
    update_multiply_adds: f64,
    /// Two operations each.
    update_gflops: f64,
    fma_peak_gflops: f64,
    update_share_of_peak: f64,
    memory_gb_per_s: f64,
    peak_memory_mib: Option<f64>,
    threads: usize,
    epochs: u32,
    graph: &'static str,
    inputs: u16,
    uavs: u16,
    worlds: u32,
    minibatch: u32,
    repeats: u32,
    /// What was compared with the other program.
    stage: &'static str,
    against: Option<Turns>,
}

/// Measures and prints.
///
/// # Errors
/// When the settings are not sound, or another program's rate is not to be had.
pub fn run(args: &Bench) -> Result<()> {
    // Learning alone: advice ends early in a run. Swarms of one size, so that all agent-steps are alike.
    let mut s = Settings { graph: Graph(args.graph.into()), teacher: 0.0, uavs_most: 0, ..Settings::default() };
    apply(&mut s, &args.set)?;
    let threads = args.threads.unwrap_or_else(|| cores().min(s.shards as usize)).max(1);
    use_threads(Some(threads));
    let workers = Workers::new(threads).into_diagnostic()?;
    if args.inputs.is_some() && s.observation != ObservationForm::Compact {
        return Err(miette!("--inputs is for the compact observation: leave it out or the setting `observation`"));
    }
    let inputs = args.inputs.unwrap_or_else(|| dimensions(&s).observation);
    let mut trainer = Trainer::with_inputs(s.clone(), inputs).into_diagnostic()?;
    let report = measure(args, &s, &mut trainer, &workers)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report).into_diagnostic()?);
    } else {
        print(&report);
    }
    Ok(())
}

fn measure(args: &Bench, s: &Settings, trainer: &mut Trainer, workers: &Workers) -> Result<Report> {
    let agent_steps = f64::from(s.worlds) * f64::from(s.steps) * f64::from(s.uavs);
    let repeats = args.repeats.max(1);
    // A round to warm up; then each stage of the same trainer, in turn.
    trainer.round(workers);
    let mut rates = [const { Vec::new() }; 4];
    let mut peaks = Vec::new();
    for _ in 0..repeats {
        peaks.push(peak_gflops(workers));
        for (stage, rates) in [Stage::Environment, Stage::Policy, Stage::Update].into_iter().zip(&mut rates) {
            rates.push(agent_steps / trainer.time(stage, workers).as_secs_f64());
        }
        rates[3].push(agent_steps / round(trainer, workers).as_secs_f64());
    }
    let against = args.against.as_ref().map(|command| {
        take_turns(command, args.marker.as_deref(), repeats, || {
            let (mut rounds, mut spent) = (0.0, Duration::ZERO);
            while spent < TURN {
                spent += match args.stage {
                    StageArg::Env => trainer.time(Stage::Environment, workers),
                    StageArg::Policy => trainer.time(Stage::Policy, workers),
                    StageArg::Update => trainer.time(Stage::Update, workers),
                    StageArg::Train => round(trainer, workers),
                };
                rounds += 1.0;
            }
            rounds * agent_steps / spent.as_secs_f64()
        })
    });
    let work = trainer.count_update(workers) as f64 / agent_steps;
    let [env, policy, update, train] = rates.map(median);
    let (peak, gflops) = (median(peaks), 2e-9 * work * update);
    let peak_memory = peak_memory_mib();
    Ok(Report {
        env_agent_steps_per_s: env,
        policy_agent_steps_per_s: policy,
        update_agent_steps_per_s: update,
        train_agent_steps_per_s: train,
        update_multiply_adds: work,
        update_gflops: gflops,
        fma_peak_gflops: peak,
        update_share_of_peak: gflops / peak,
        memory_gb_per_s: memory_gb_per_s(workers),
        peak_memory_mib: peak_memory,
        threads: workers.threads(),
        epochs: s.epochs,
        graph: s.graph.0.name(),
        inputs: args.inputs.unwrap_or_else(|| dimensions(s).observation),
        uavs: s.uavs,
        worlds: s.worlds,
        minibatch: s.minibatch,
        repeats,
        stage: stage_name(args.stage),
        against: against.transpose()?,
    })
}

/// Time of a round of training.
fn round(trainer: &mut Trainer, workers: &Workers) -> Duration {
    let start = Instant::now();
    trainer.round(workers);
    start.elapsed()
}

const fn stage_name(stage: StageArg) -> &'static str {
    match stage {
        StageArg::Env => "environment and observation",
        StageArg::Policy => "policy: environment, actor, critic",
        StageArg::Update => "update",
        StageArg::Train => "training, all of it",
    }
}

fn print(r: &Report) {
    println!(
        "{} of {} inputs on {} thread(s), {} epochs, medians of {}:",
        r.graph, r.inputs, r.threads, r.epochs, r.repeats
    );
    for (what, rate) in [
        (stage_name(StageArg::Env), r.env_agent_steps_per_s),
        (stage_name(StageArg::Policy), r.policy_agent_steps_per_s),
        (stage_name(StageArg::Update), r.update_agent_steps_per_s),
        (stage_name(StageArg::Train), r.train_agent_steps_per_s),
    ] {
        println!("  {what:<36} {rate:>9.0} agent-steps/s");
    }
    println!(
        "  the update's products: {:.0} thousand multiply-adds an agent-step, {:.1} GFLOP/s, {:.0} % of the {:.1} that \
         this machine does in registers",
        r.update_multiply_adds / 1e3,
        r.update_gflops,
        100.0 * r.update_share_of_peak,
        r.fma_peak_gflops
    );
    println!("  memory: {:.1} GB/s read", r.memory_gb_per_s);
    if let Some(peak) = r.peak_memory_mib {
        println!("  at most {peak:.0} MiB in use");
    }
    if let Some(t) = &r.against {
        println!("  {}, and {}:", r.stage, t.command);
        for (own, other) in t.own_rates.iter().zip(&t.rates) {
            println!("    {own:>9.0} {other:>9.0} agent-steps/s: {:.2} times", own / other);
        }
        println!("    median: {:.2} times", t.ratio);
    }
}

/// The middle one, or the mean of both.
pub(super) fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2].midpoint(v[(v.len() - 1) / 2])
}
