//! The measurements.

use super::against::take_turns;
use super::machine::{memory_gb_per_s, peak_gflops, peak_memory_mib};
use super::median::median;
use super::report::{Report, print, stage_name};
use crate::cli::{Bench, BenchStage, Device};
use crate::commands::device::put;
use crate::commands::hold::Hold;
use crate::commands::interrupt::Stop;
use crate::commands::output::say_out;
use crate::commands::settings::apply;
use crate::commands::threads::{cores, use_threads};
use crate::settings::{Settings, word_of};
use crate::train::{Stage, Trainer, Workers, dimensions};
use covey_env::ObservationForm;
use miette::{IntoDiagnostic, Result, miette};
use std::time::{Duration, Instant};

/// Least time of a measurement beside another program.
const TURN: Duration = Duration::from_secs(4);

/// Measures and prints.
///
/// # Errors
/// When the settings are not sound, or another program's rate is not to be had.
pub fn run(args: &Bench) -> Result<()> {
    // Learning from reward alone: behaviour cloning ends early in a run. Swarms of one size, so that all agent-steps are alike.
    let mut s = Settings { graph: args.graph, cloning_weight: 0.0, uavs_max: 0, ..Settings::default() };
    apply(&mut s, &args.set)?;
    let _stop = Stop::with_words("stopped measuring; the same command begins again".into())?;
    let threads = args.threads.unwrap_or_else(|| cores().min(s.shards as usize)).max(1);
    use_threads(Some(threads));
    let workers = Workers::new(threads).into_diagnostic()?;
    if args.inputs.is_some() && s.observation != ObservationForm::Compact {
        return Err(miette!("--inputs is for the compact observation: leave it out or the setting `observation`"));
    }
    let inputs = args.inputs.unwrap_or_else(|| dimensions(&s).observation);
    let mut trainer = Trainer::with_inputs(s.clone(), inputs).into_diagnostic()?;
    let mut on_device = if args.device == Device::Cpu {
        None
    } else {
        let other = Trainer::with_inputs(s.clone(), inputs).into_diagnostic()?;
        Some(put(other, args.device)?)
    };
    Hold::before_measuring()?;
    let report = measure(args, &s, &mut trainer, on_device.as_mut(), &workers)?;
    if args.json {
        say_out!("{}", serde_json::to_string_pretty(&report).into_diagnostic()?)?;
    } else {
        print(&report)?;
    }
    Ok(())
}

fn measure(
    args: &Bench,
    s: &Settings,
    on_cpu: &mut Trainer,
    mut on_device: Option<&mut Trainer>,
    workers: &Workers,
) -> Result<Report> {
    let agent_steps = f64::from(s.num_envs) * f64::from(s.steps) * f64::from(s.uavs);
    let repeats = args.repeats.max(1);
    // A round to warm up; then each stage of the same trainer, in turn.
    round(on_cpu, workers)?;
    on_device.as_mut().map_or(Ok(Duration::ZERO), |t| round(t, workers))?;
    let (mut by_cpu, mut by_device) = (Rates::default(), Rates::default());
    let mut peaks = Vec::new();
    for _ in 0..repeats {
        peaks.push(peak_gflops(workers));
        measure_stages(&mut by_cpu, on_cpu, workers, agent_steps)?;
        if let Some(trainer) = &mut on_device {
            measure_stages(&mut by_device, trainer, workers, agent_steps)?;
        }
    }
    let work = on_cpu.count_update(workers).into_diagnostic()? as f64 / agent_steps;
    let cpu = by_cpu.map(median);
    let (trainer, [env, policy, update, train]) = match on_device {
        Some(trainer) => (trainer, by_device.map(median)),
        None => (on_cpu, cpu),
    };
    let device = trainer.device();
    let mut failed = None;
    let against = args.against.as_ref().map(|command| {
        take_turns(command, args.marker.as_deref(), repeats, || {
            let (mut rounds, mut spent) = (0.0, Duration::ZERO);
            while spent < TURN && failed.is_none() {
                let took = match args.stage {
                    BenchStage::Env => time(trainer, Stage::Environment, workers),
                    BenchStage::Policy => time(trainer, Stage::Policy, workers),
                    BenchStage::Update => time(trainer, Stage::Update, workers),
                    BenchStage::Train => round(trainer, workers),
                };
                match took {
                    Ok(took) => spent += took,
                    Err(e) => failed = Some(e),
                }
                rounds += 1.0;
            }
            rounds * agent_steps / spent.as_secs_f64()
        })
    });
    failed.map_or(Ok(()), Err)?;
    let (peak, gflops) = (median(peaks), 2e-9 * work * cpu[2]);
    let peak_memory = peak_memory_mib();
    Ok(Report {
        env_agent_steps_per_s: env,
        policy_agent_steps_per_s: policy,
        update_agent_steps_per_s: update,
        train_agent_steps_per_s: train,
        cpu_agent_steps_per_s: (args.device != Device::Cpu).then_some(cpu),
        device,
        update_multiply_adds: work,
        update_gflops: gflops,
        fma_peak_gflops: peak,
        update_share_of_peak: gflops / peak,
        memory_gb_per_s: memory_gb_per_s(workers),
        peak_memory_mib: peak_memory,
        threads: workers.threads(),
        epochs: s.epochs,
        graph: word_of(s.graph),
        inputs: args.inputs.unwrap_or_else(|| dimensions(s).observation),
        uavs: s.uavs,
        worlds: s.num_envs,
        minibatch: s.minibatch,
        repeats,
        stage: stage_name(args.stage),
        against: against.transpose()?,
    })
}

/// Agent-steps a second of the environment, the rollout, the update and training.
type Rates = [Vec<f64>; 4];

fn measure_stages(rates: &mut Rates, trainer: &mut Trainer, workers: &Workers, agent_steps: f64) -> Result<()> {
    for (stage, rates) in [Stage::Environment, Stage::Policy, Stage::Update].into_iter().zip(&mut *rates) {
        rates.push(agent_steps / time(trainer, stage, workers)?.as_secs_f64());
    }
    rates[3].push(agent_steps / round(trainer, workers)?.as_secs_f64());
    Ok(())
}

/// Time of a stage.
fn time(trainer: &mut Trainer, stage: Stage, workers: &Workers) -> Result<Duration> {
    trainer.time(stage, workers).into_diagnostic()
}

/// Time of a round of training.
fn round(trainer: &mut Trainer, workers: &Workers) -> Result<Duration> {
    let start = Instant::now();
    trainer.round(workers).into_diagnostic()?;
    Ok(start.elapsed())
}
