//! `bench`: how fast this machine plays and learns.

use super::{apply, cores, use_threads};
use crate::cli::Bench;
use crate::settings::{Graph, Settings};
use crate::train::{Stage, Trainer, Workers};
use miette::{IntoDiagnostic, Result};
use serde::Serialize;
use std::time::Instant;

/// What `bench --json` prints: medians over the repeats, agent-steps per second.
#[derive(Serialize)]
struct Rates {
    env_agent_steps_per_s: f64,
    policy_agent_steps_per_s: f64,
    update_agent_steps_per_s: f64,
    train_agent_steps_per_s: f64,
    /// Floating-point operations of an update, those with a zero left out: two a multiply-add.
    update_gflop_per_s: f64,
    update_multiply_adds_per_agent_step: f64,
    threads: usize,
    epochs: u32,
    graph: &'static str,
    uavs: u16,
    worlds: u32,
    minibatch: u32,
    repeats: u32,
}

/// Measures and prints.
///
/// # Errors
/// When the settings are not sound.
pub fn run(args: &Bench) -> Result<()> {
    // Learning alone: the planner's advice ends early in a run and has its own cost.
    let mut s = Settings { graph: Graph(args.graph.into()), teacher: 0.0, ..Settings::default() };
    apply(&mut s, &args.set)?;
    let threads = args.threads.unwrap_or_else(|| cores().min(s.shards as usize)).max(1);
    use_threads(Some(threads));
    let workers = Workers::new(threads).into_diagnostic()?;
    let mut trainer = Trainer::new(s.clone()).into_diagnostic()?;
    let agent_steps = f64::from(s.worlds) * f64::from(s.steps) * f64::from(s.uavs);
    // A round to warm up; then each stage of the same trainer, in turn.
    trainer.round(&workers);
    let mut rates = [const { Vec::new() }; 4];
    for _ in 0..args.repeats.max(1) {
        for (stage, rates) in [Stage::Environment, Stage::Policy, Stage::Update].into_iter().zip(&mut rates) {
            rates.push(agent_steps / trainer.time(stage, &workers).as_secs_f64());
        }
        let start = Instant::now();
        trainer.round(&workers);
        rates[3].push(agent_steps / start.elapsed().as_secs_f64());
    }
    let multiply_adds = trainer.count_update(&workers) as f64 / agent_steps;
    let [env, policy, update, train] = rates.map(median);
    let out = Rates {
        env_agent_steps_per_s: env,
        policy_agent_steps_per_s: policy,
        update_agent_steps_per_s: update,
        train_agent_steps_per_s: train,
        update_gflop_per_s: 2e-9 * multiply_adds * update,
        update_multiply_adds_per_agent_step: multiply_adds,
        threads,
        epochs: s.epochs,
        graph: s.graph.0.name(),
        uavs: s.uavs,
        worlds: s.worlds,
        minibatch: s.minibatch,
        repeats: args.repeats.max(1),
    };
    if args.json {
        println!("{}", serde_json::to_string_pretty(&out).into_diagnostic()?);
    } else {
        println!("{} on {threads} thread(s), {} epochs, medians of {}:", out.graph, out.epochs, out.repeats);
        for (what, rate) in [
            ("environment and observation", env),
            ("policy: environment, actor, critic", policy),
            ("update", update),
            ("training, all of it", train),
        ] {
            println!("  {what:<36} {:>9.0} agent-steps/s", rate);
        }
        println!(
            "  update: {:.0} thousand multiply-adds an agent-step, {:.1} GFLOP/s",
            multiply_adds / 1e3,
            out.update_gflop_per_s
        );
    }
    Ok(())
}

fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2].midpoint(v[(v.len() - 1) / 2])
}
