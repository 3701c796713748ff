//! A long flight against the simulated autopilots, to see that nothing grows, nothing is missed and no clock's end
//! is a flight's: `cargo run --release -p sitl-bridge --example soak -- --hours 24`.
//!
//! On the way wrap the vehicles' 32-bit clocks, the swarm's common clock in neighbour messages, the step number and
//! the sequence numbers. Prints a line each simulated hour, and ends with status 1 when memory grew or a decision is
//! missing.

#[path = "../tests/fleet/swarm.rs"]
mod swarm;

use clap::Parser;
use covey_env::{Scenario, World};
use firmware_core::gate::Limits;
use serde_json::{Value, json};
use sitl_bridge::mission::{Layers, Mission, Origin};
use sitl_bridge::node::Counters;
use sitl_bridge::node::run::NodeEvent;
use std::collections::BTreeMap;
use std::fs;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use swarm::{Plan, Swarm};

const HOUR_MS: i64 = 3_600_000;
/// A clock of 32 bits, ms.
const WRAP_MS: i64 = 1 << 32;
/// Unix times near now whose lower 32 bits are zero are multiples of [`WRAP_MS`]: this one is in November 2026.
const UNIX_WRAPS: i64 = 418;
/// Memory in use settles in this part of the flight; what comes on top later is growth.
const SETTLED: f64 = 0.125;
/// Growth that is none: allocators and interpreters breathe, KiB.
const BREATH_KIB: u64 = 2048;

#[derive(Parser)]
struct Args {
    /// Simulated hours.
    #[arg(long, default_value_t = 24.0)]
    hours: f64,
    /// UAVs.
    #[arg(long, default_value_t = 8)]
    uavs: u16,
}

/// What is known of one UAV's flight.
#[derive(Clone, Default)]
struct UavFlight {
    first: Option<u32>,
    last: u32,
    decisions: u64,
    late: u64,
}

#[derive(Default)]
struct Account {
    flown: Vec<UavFlight>,
    clock_ms: i64,
    /// Warnings of the nodes and events of the fleet by their words.
    words: BTreeMap<String, u64>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let length_ms = (args.hours * HOUR_MS as f64) as i64;
    let start_ms = UNIX_WRAPS * WRAP_MS - length_ms / 4;
    let mut swarm = Swarm::launch(&plan(args.uavs, start_ms, length_ms));
    let mut account = Account { flown: vec![UavFlight::default(); usize::from(args.uavs)], ..Account::default() };
    let (began, mut sampled, mut settled) = (Instant::now(), 0, None);
    let mut heard = Instant::now();
    println!("simulated h, wall s, x real time, decisions, nodes KiB, fleet KiB");
    while account.clock_ms - start_ms < length_ms {
        if let Ok(report) = swarm.reports.recv_timeout(Duration::from_millis(100)) {
            account.take(report);
            swarm.reports.try_iter().for_each(|report| account.take(report));
            heard = Instant::now();
        }
        assert!(heard.elapsed() < Duration::from_secs(60), "the flight stands still: {:?}", account.words);
        swarm.fleet.events().unwrap_or_else(|error| panic!("{error}")).iter().for_each(|event| account.hear(event));
        let flown_ms = account.clock_ms - start_ms;
        if flown_ms / (HOUR_MS / 4) > sampled {
            sampled = flown_ms / (HOUR_MS / 4);
            let memory = [resident_kib("self"), resident_kib(&swarm.fleet.process().to_string())];
            let (hours, wall_s) = (flown_ms as f64 / HOUR_MS as f64, began.elapsed().as_secs_f64());
            let decisions: u64 = account.flown.iter().map(|f| f.decisions).sum();
            let factor = hours * 3600.0 / wall_s;
            println!("{hours:.2}, {wall_s:.0}, {factor:.0}, {decisions}, {}, {}", memory[0], memory[1]);
            if flown_ms as f64 >= length_ms as f64 * SETTLED {
                settled.get_or_insert(memory);
            }
        }
    }
    let memory = [resident_kib("self"), resident_kib(&swarm.fleet.process().to_string())];
    let (counters, last) = swarm.end();
    last.iter().for_each(|event| account.hear(event));
    let grown = settled.map(|then| [0, 1].map(|i| memory[i].saturating_sub(then[i])));
    if judge(&account, &counters, grown) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn plan(uavs: u16, start_ms: i64, length_ms: i64) -> Plan {
    let scenario = Scenario { uavs: usize::from(uavs), ..Scenario::default() };
    let mut world = World::new(&scenario).expect("a scenario that can be");
    world.reset(777, 0);
    let mut mission = Mission::of_world(&world, Origin::default()).expect("a place for the map");
    mission.layers = Layers { base_m: 10.0, spacing_m: 1.0, count: uavs };
    // Step 2³² = step 0 in the middle of the flight.
    let step_ms = i64::from(mission.scale.step_ms);
    mission.epoch_unix_ms = (start_ms + length_ms / 2).div_euclid(step_ms) * step_ms - WRAP_MS * step_ms;
    let pads = (0..usize::from(uavs)).map(|i| world.position(i)).map(|(x, y)| [x, y].map(f64::from)).collect();
    let fleet = json!({
        "unix_ms": start_ms,
        "boot_ms": WRAP_MS - length_ms / 3,
        // While nobody streams: in bring-up.
        "speed": 40,
        "lockstep_timeout_s": 30,
    });
    let Value::Object(fleet) = fleet else { unreachable!() };
    // The nodes' own clocks are the only ones that see how busy this computer is.
    let limits = Limits { link_wall_ms: 120_000, ..Limits::simulation() };
    Plan { mission, pads, sequence: Some(40_000), limits, fleet }
}

impl Account {
    fn take(&mut self, (id, report): (usize, NodeEvent)) {
        match report {
            NodeEvent::Clock(common_ms) => self.clock_ms = self.clock_ms.max(common_ms),
            NodeEvent::StepStarted(begun) => self.clock_ms = self.clock_ms.max(begun.common_ms),
            NodeEvent::Decision(decision) => {
                let flown = &mut self.flown[id];
                flown.first.get_or_insert(decision.step);
                flown.last = decision.step;
                flown.decisions += 1;
                flown.late += u64::from(decision.late);
            }
            NodeEvent::Notice(notice) if notice.warning => *self.words.entry(notice.text).or_default() += 1,
            NodeEvent::Notice(_) | NodeEvent::Stage(_) | NodeEvent::Status(_) | NodeEvent::Ended(_) => {}
        }
    }

    fn hear(&mut self, event: &Value) {
        let name = event["event"].as_str().unwrap_or_default();
        if matches!(name, "timeout" | "failsafe" | "crash" | "lockstep_timeout" | "error") {
            *self.words.entry(format!("fleet: {name}")).or_default() += 1;
        }
    }
}

/// Tells how it went; says whether it went well.
fn judge(account: &Account, counters: &[Counters], grown: Option<[u64; 2]>) -> bool {
    let mut total = Counters::default();
    counters.iter().for_each(|c| total.add(c));
    // A step from the first to the last without its decision.
    let steps = |f: &UavFlight| f.first.map_or(0, |first| u64::from(f.last.wrapping_sub(first)) + 1);
    let missing: u64 = account.flown.iter().map(|f| steps(f) - f.decisions).sum();
    let late: u64 = account.flown.iter().map(|f| f.late).sum();
    println!("{}", total.to_json(account.flown.len() as u16));
    println!("steps without a decision: {missing}, counted as missed: {}; late: {late}", total.missed_decisions);
    println!("warnings and troubles: {:?}", account.words);
    println!("memory grown since an eighth of the flight, nodes and fleet: {grown:?} KiB");
    let steady = grown.is_some_and(|grown| grown.iter().all(|&kib| kib <= BREATH_KIB));
    steady && missing == total.missed_decisions && late == total.late_decisions
}

/// Memory of a process that lies in RAM, KiB.
fn resident_kib(process: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()).and_then(|kib| kib.parse().ok()).unwrap_or(0)
}
