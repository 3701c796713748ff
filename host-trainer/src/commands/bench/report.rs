//! What `bench` prints.

use super::against::Turns;
use crate::cli::BenchStage;
use crate::commands::output::say_out;
use miette::Result;
use serde::Serialize;

/// What `bench --json` prints. Rates are medians over the repeats, agent-steps per second.
#[derive(Serialize)]
pub struct Report {
    pub env_agent_steps_per_s: f64,
    pub policy_agent_steps_per_s: f64,
    pub update_agent_steps_per_s: f64,
    pub train_agent_steps_per_s: f64,
    pub device: String,
    /// The same four rates with the networks on the CPU, where `device` is another.
    pub cpu_agent_steps_per_s: Option<[f64; 4]>,
    /// Multiply-adds of the update an agent-step, those with a zero left out; of the CPU, as
    /// are the next three.
    pub update_multiply_adds: f64,
    /// Two operations each.
    pub update_gflops: f64,
    pub fma_peak_gflops: f64,
    pub update_share_of_peak: f64,
    pub memory_gb_per_s: f64,
    pub peak_memory_mib: Option<f64>,
    pub threads: usize,
    pub epochs: u32,
    pub graph: &'static str,
    pub inputs: u16,
    pub uavs: u16,
    pub worlds: u32,
    pub minibatch: u32,
    pub repeats: u32,
    /// What was compared with the other program.
    pub stage: &'static str,
    pub against: Option<Turns>,
}

/// A stage in words.
pub const fn stage_name(stage: BenchStage) -> &'static str {
    match stage {
        BenchStage::Env => "environment and observation",
        BenchStage::Policy => "policy: environment, actor, critic",
        BenchStage::Update => "update",
        BenchStage::Train => "training, all of it",
    }
}

/// Prints it for people.
///
/// # Errors
/// When standard output takes no more.
pub fn print(r: &Report) -> Result<()> {
    say_out!(
        "{} of {} inputs on {} thread(s), {} epochs, {} worlds, minibatch {}, medians of {}:",
        r.graph,
        r.inputs,
        r.threads,
        r.epochs,
        r.worlds,
        r.minibatch,
        r.repeats
    )?;
    if r.cpu_agent_steps_per_s.is_some() {
        say_out!("  {:<36} {:>9}               on the CPU (networks on {})", "", "", r.device)?;
    }
    for (k, (what, rate)) in [
        (stage_name(BenchStage::Env), r.env_agent_steps_per_s),
        (stage_name(BenchStage::Policy), r.policy_agent_steps_per_s),
        (stage_name(BenchStage::Update), r.update_agent_steps_per_s),
        (stage_name(BenchStage::Train), r.train_agent_steps_per_s),
    ]
    .into_iter()
    .enumerate()
    {
        let beside = r.cpu_agent_steps_per_s.map(|cpu| format!(" {:>9.0}: {:.2} times", cpu[k], rate / cpu[k]));
        say_out!("  {what:<36} {rate:>9.0} agent-steps/s{}", beside.unwrap_or_default())?;
    }
    say_out!(
        "  the update's products: {:.0} thousand multiply-adds an agent-step, {:.1} GFLOP/s, {:.0} % of the {:.1} that \
         this machine does in registers",
        r.update_multiply_adds / 1e3,
        r.update_gflops,
        100.0 * r.update_share_of_peak,
        r.fma_peak_gflops
    )?;
    say_out!("  memory: {:.1} GB/s read", r.memory_gb_per_s)?;
    if let Some(peak) = r.peak_memory_mib {
        say_out!("  at most {peak:.0} MiB in use")?;
    }
    if let Some(t) = &r.against {
        say_out!("  {}, and {}:", r.stage, t.command)?;
        for (own, other) in t.own_rates.iter().zip(&t.rates) {
            say_out!("    {own:>9.0} {other:>9.0} agent-steps/s: {:.2} times", own / other)?;
        }
        say_out!("    median: {:.2} times", t.ratio)?;
    }
    Ok(())
}
