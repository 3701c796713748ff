//! `cargo xtask counts`: instruction counts of the trainer's parts, measured by valgrind's callgrind.
//!
//! Valgrind runs every program on the same simulated processor, which has AVX2, and counts the instructions that are
//! executed. So the counts are exactly the same on every computer with AVX2, as long as the compiler is the same.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::command::Cmd;
use crate::document;
use crate::error::{Error, Result};
use crate::figures::{self, grouped, is_close};
use crate::output::{print, tell};
use crate::setup::{self, Item};
use crate::workspace;

/// What must be installed to count instructions.
pub const NEEDS: &[Item] = &[Item::Valgrind];

/// The largest ratio of instructions per agent-step between a large world and the default one.
const GROWTH: u64 = 2;
/// Pairs of parts that do the same work in a large world and in the default one.
const GROWING: [(&str, &str); 2] = [("environment_980", "environment_20"), ("flight_500", "flight_20")];

/// Options of `cargo xtask counts`.
#[derive(clap::Args)]
pub struct Args {
    /// Print the counts as a JSON array, and nothing else on the standard output.
    #[arg(long)]
    json: bool,
    /// Commit to today's counts: write docs/counts.json and the table of docs/performance.md.
    #[arg(long)]
    bless: bool,
}

/// The instruction count of one part of the trainer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Count {
    /// Name of the part in the example `counted` of covey-net.
    part: String,
    /// How much was done: agent-steps, or samples of training.
    agent_steps: u64,
    /// Instructions that it took.
    instructions: u64,
}

/// Counts the instructions of every part and checks the counts.
///
/// # Errors
/// A build or a run failed, or counts are not what they should be; the error names all of them.
pub fn main(args: &Args) -> Result<()> {
    if !has_avx2() {
        return print("left out: the counts are of the code for AVX2 and FMA, which this processor does not have\n");
    }
    setup::install(NEEDS)?;
    let counts = measure()?;
    let text = if args.json { figures::json(&counts) } else { table(&counts) };
    print(&format!("{text}\n"))?;
    let path = workspace::root().join("docs/counts.json");
    if args.bless {
        figures::write(&path, &counts)?;
        document::replace_table("docs/performance.md", "counts", &table(&counts))?;
    }
    let complaints = complaints(&counts, &figures::read(&path)?);
    if complaints.is_empty() {
        tell!("counts: every count is within its limits");
        return Ok(());
    }
    Err(Error::Figures(complaints.join("\n") + "\nafter a deliberate change: cargo xtask counts --bless"))
}

/// Whether this processor can run the code that is counted.
fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Builds the example and counts each of its parts.
fn measure() -> Result<Vec<Count>> {
    let example = ["build", "--quiet", "--release", "--package", "covey-net", "--example", "counted"];
    Cmd::cargo().args(example).read()?;
    let program = workspace::target_folder().join("release/examples/counted");
    let parts = Cmd::new(&program).read()?;
    parts.lines().map(|part| count(&program, part)).collect()
}

/// Counts the instructions of one part.
fn count(program: &Path, part: &str) -> Result<Count> {
    tell!("counts: {part}");
    let command = Cmd::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--toggle-collect=counted::counted"])
        .arg(PathBuf::from(program))
        .arg(part);
    let printed = command.read_all()?;
    read(&printed)
        .map(|(agent_steps, instructions)| Count { part: part.into(), agent_steps, instructions })
        .ok_or_else(|| Error::Output { command: command.to_string(), printed })
}

/// Reads agent-steps and instructions from the output of the program and of valgrind.
fn read(printed: &str) -> Option<(u64, u64)> {
    let agent_steps = printed.lines().find_map(|line| line.parse().ok())?;
    let (_, collected) = printed.split_once("Collected : ")?;
    let instructions = collected.split_whitespace().next()?.parse().ok()?;
    // Valgrind counts nothing if there is no function of the name that it was given.
    (agent_steps > 0 && instructions > 0).then_some((agent_steps, instructions))
}

/// Compares the counts with the committed ones and returns a line for each difference.
fn complaints(counts: &[Count], committed: &[Count]) -> Vec<String> {
    let mut found = Vec::new();
    for now in counts {
        match committed.iter().find(|then| then.part == now.part) {
            Some(then) if then.agent_steps != now.agent_steps => found.push(format!(
                "{}: {} agent-steps, committed {}: the work is not the same",
                now.part, now.agent_steps, then.agent_steps
            )),
            Some(then) if !is_close(now.instructions, then.instructions) => {
                found.push(format!(
                    "{}: {} instructions, committed {}",
                    now.part,
                    grouped(now.instructions),
                    grouped(then.instructions)
                ));
            }
            Some(_) => {}
            None => found.push(format!("{}: not in the committed counts", now.part)),
        }
    }
    for then in committed {
        if counts.iter().all(|now| now.part != then.part) {
            found.push(format!("{}: committed, but not counted any more", then.part));
        }
    }
    let by_name = |name| counts.iter().find(|c| c.part == name);
    for (large, small) in GROWING {
        if let (Some(large), Some(small)) = (by_name(large), by_name(small))
            && large.instructions * small.agent_steps > GROWTH * small.instructions * large.agent_steps
        {
            found.push(format!("{}: more than {GROWTH} times {} an agent-step", large.part, small.part));
        }
    }
    found
}

/// The counts as a Markdown table.
fn table(counts: &[Count]) -> String {
    let mut table = "| part | agent-steps | instructions | an agent-step |\n|---|--:|--:|--:|\n".to_owned();
    for c in counts {
        table += &format!(
            "| {} | {} | {} | {} |\n",
            c.part,
            grouped(c.agent_steps),
            grouped(c.instructions),
            grouped(c.instructions / c.agent_steps.max(1))
        );
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(part: &str, agent_steps: u64, instructions: u64) -> Count {
        Count { part: part.into(), agent_steps, instructions }
    }

    #[test]
    fn counts_are_found_among_what_valgrind_prints() {
        let printed = "2000\n==7== Events    : Ir\n==7== Collected : 7689348\n==7== \n==7== I   refs:      7,689,348\n";
        assert_eq!(read(printed), Some((2000, 7_689_348)));
        assert_eq!(read(&printed.replace("7689348", "0")), None);
        assert_eq!(read("==7== Collected : 5\n"), None);
        assert_eq!(read("2000\n"), None);
    }

    #[test]
    fn counts_may_move_three_in_a_hundred() {
        let with = |count| complaints(&[of("a", 2, count)], &[of("a", 2, 1000)]);
        assert!(with(1030).is_empty() && with(970).is_empty());
        assert_eq!(with(1031), ["a: 1,031 instructions, committed 1,000"]);
        assert_eq!(with(969).len(), 1);
    }

    #[test]
    fn other_work_and_other_parts_are_named() {
        assert_eq!(complaints(&[of("a", 3, 1000)], &[of("a", 2, 1000)]).len(), 1);
        let found = complaints(&[of("a", 2, 1000)], &[of("b", 2, 1000)]);
        assert_eq!(found, ["a: not in the committed counts", "b: committed, but not counted any more"]);
    }

    #[test]
    fn a_large_world_costs_an_agent_step_at_most_twice_as_much() {
        let with = |large| {
            let counts = [of("flight_20", 10, 1000), of("flight_500", 100, large)];
            complaints(&counts, &counts)
        };
        assert!(with(20_000).is_empty());
        assert_eq!(with(20_001), ["flight_500: more than 2 times flight_20 an agent-step"]);
    }
}
