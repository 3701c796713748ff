//! Agent-steps a second, with observations, on one thread.
//!
//! `cargo run --release -p covey-env --example speed`

use covey_env::baselines::{Centroid, Random};
use covey_env::{Neighbourhood, Observer, Policy, Scenario, World};
use firmware_core::action::Action;
use firmware_core::observation::LEN;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("agent-steps/s on one thread          step   observe      both");
    let base = Scenario::default();
    let large = |k: usize| Scenario { uavs: 20 * k * k, pois: 120 * k * k, side_u: 200.0 * k as f32, ..base.clone() };
    measure("random actions", &base, &mut Random::new(1, 0))?;
    measure("centroid heuristic", &base, &mut Centroid::new(1, 0))?;
    measure("the same, 9 times the map", &large(3), &mut Centroid::new(1, 0))?;
    measure("the same, 49 times the map", &large(7), &mut Centroid::new(1, 0))?;
    measure("200 UAVs on the same map", &Scenario { uavs: 200, ..base }, &mut Random::new(1, 0))?;
    Ok(())
}

/// Flies recorded actions over and over, so that the policy's own time does not count.
fn measure(name: &str, scenario: &Scenario, policy: &mut dyn Policy) -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::new(scenario)?;
    policy.begin(&world);
    let mut actions = vec![Action::COAST; scenario.uavs];
    let mut script = Vec::new();
    while !world.done() {
        policy.act(&world, &mut actions);
        world.step(&actions);
        script.push(actions.clone());
    }
    let mut observer = Observer::new(1, 1);
    let mut observations = vec![[0; LEN]; scenario.uavs];
    let mut neighbourhoods = vec![Neighbourhood::default(); scenario.uavs];
    let mut rate = |observe: bool| {
        let (start, mut agent_steps) = (Instant::now(), 0);
        while start.elapsed().as_secs_f64() < 0.5 {
            world.reset(0, 0);
            for actions in &script {
                world.step(actions);
                if observe {
                    observer.observe(&world, &mut observations, &mut neighbourhoods);
                }
            }
            agent_steps += script.len() * scenario.uavs;
        }
        agent_steps as f64 / start.elapsed().as_secs_f64()
    };
    let (step, both) = (rate(false), rate(true));
    let observe = 1.0 / (1.0 / both - 1.0 / step);
    println!("{name:30} {:8.2} M {:7.2} M {:7.2} M", step / 1e6, observe / 1e6, both / 1e6);
    Ok(())
}
