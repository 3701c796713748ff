//! One part of the work, once warm, for instructions to be counted: of `counted` alone.
//!
//! `cargo run --release -p covey-net --example counted` lists the parts; `cargo xtask counts`
//! runs each under valgrind and compares with the committed counts.

#[path = "../benches/work/mod.rs"]
mod work;

use firmware_core::actor::{Actor, Aggregation};
use std::process::ExitCode;
use work::{Environment, Flight, Networks, large};

/// World-steps that the networks take: two micro-batches.
const WORLD_STEPS: usize = 12;

/// Names of the parts.
const PARTS: [&str; 11] = [
    "environment_20",
    "environment_980",
    "flight_20",
    "flight_500",
    "actor_forward_none",
    "actor_forward_gcn",
    "actor_gradient_gcn",
    "actor_gradient_gat",
    "critic_forward",
    "critic_gradient",
    "minibatch_gcn",
];

/// What is counted; `cargo xtask counts` knows it by its name.
#[inline(never)]
fn counted(part: &mut dyn FnMut()) {
    part();
}

/// Warms up, then runs the part to count; returns agent-steps.
fn run(part: &str) -> Option<u64> {
    let networks = |aggregation, part: fn(&mut Networks)| {
        let mut networks = Networks::new(aggregation, WORLD_STEPS);
        part(&mut networks);
        counted(&mut || part(&mut networks));
        networks.micro_batch()
    };
    let environment = |k| {
        let mut environment = Environment::new(&large(k));
        environment.episode();
        counted(&mut || environment.episode());
        environment.agent_steps()
    };
    let file = work::actor_file();
    let flight = |k| {
        let mut flight = Flight::new(&large(k), Actor::load(&file).expect("a sound actor file"));
        flight.episode();
        counted(&mut || flight.episode());
        flight.agent_steps()
    };
    Some(match part {
        "environment_20" => environment(1),
        "environment_980" => environment(7),
        "flight_20" => flight(1),
        "flight_500" => flight(5),
        "actor_forward_none" => networks(Aggregation::None, Networks::actor_forward),
        "actor_forward_gcn" => networks(Aggregation::Gcn, Networks::actor_forward),
        "actor_gradient_gcn" => networks(Aggregation::Gcn, Networks::actor_gradient),
        "actor_gradient_gat" => networks(Aggregation::Gat, Networks::actor_gradient),
        "critic_forward" => networks(Aggregation::Gcn, Networks::critic_forward),
        "critic_gradient" => networks(Aggregation::Gcn, Networks::critic_gradient),
        "minibatch_gcn" => {
            let mut networks = Networks::new(Aggregation::Gcn, WORLD_STEPS);
            networks.minibatch();
            counted(&mut || networks.minibatch());
            networks.samples()
        }
        _ => return None,
    })
}

/// Prints the agent-steps that were counted.
fn main() -> ExitCode {
    let Some(part) = std::env::args().nth(1) else {
        println!("{}", PARTS.join("\n"));
        return ExitCode::SUCCESS;
    };
    match run(&part) {
        Some(agent_steps) => {
            println!("{agent_steps}");
            ExitCode::SUCCESS
        }
        None => {
            eprintln!("there is no part `{part}`; there are {}", PARTS.join(", "));
            ExitCode::FAILURE
        }
    }
}
