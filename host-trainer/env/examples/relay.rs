//! What relayed knowledge is worth: the planner with the memory of the board, by bytes a UAV and step, and by UAVs.
//!
//! `cargo run --release -p covey-env --example relay [WORLDS [SEED]]`

use covey_env::baselines::{RelayingPlanner, RememberingPlanner};
use covey_env::{Evaluation, PoiDistribution, Scenario, evaluate};
use firmware_core::memory::MAX_KNOWLEDGE;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let worlds = args.next().map_or(Ok(200), |a| a.parse())?;
    let seed = args.next().map_or(Ok(777), |a| a.parse())?;
    let base = Scenario::default();
    let relaying = |scenario: &Scenario, bytes| evaluate(scenario, seed, worlds, |_| RelayingPlanner::new(bytes));
    println!("{worlds} worlds of seed {seed}: coverage, last step, energy, reward");
    for bytes in [0, 25, 50, 100, MAX_KNOWLEDGE] {
        show(&format!("{bytes} bytes"), &relaying(&base, bytes)?);
    }
    show("remembering", &evaluate(&base, seed, worlds, |_| RememberingPlanner::new())?);
    for uavs in [5, 10, 15, 25, 30] {
        show(&format!("{uavs} UAVs"), &relaying(&Scenario { uavs, ..base.clone() }, MAX_KNOWLEDGE)?);
    }
    let uniform = Scenario { distribution: PoiDistribution::Uniform, ..base };
    show("uniform PoIs", &relaying(&uniform, MAX_KNOWLEDGE)?);
    Ok(())
}

fn show(name: &str, evaluation: &Evaluation) {
    let (mean, error) = (evaluation.mean(), evaluation.standard_error());
    println!(
        "{name:14} {:.4} ±{:.4}   {:.4} ±{:.4}   {:.3}   {:.1} ±{:.1}",
        mean.coverage, error.coverage, mean.coverage_last, error.coverage_last, mean.energy, mean.reward, error.reward
    );
}
