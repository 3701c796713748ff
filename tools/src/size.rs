//! `cargo xtask size FILE`: flash, RAM, stack and instructions of an actor file on a flight controller, and whether
//! they are within the limits.

use std::fs;
use std::path::PathBuf;

use firmware_core::actor::{Actor, Aggregation};

use crate::error::{Error, Result};
use crate::figures::grouped;
use crate::setup;
use crate::targets::artefacts::{Board, Image};
use crate::targets::qemu::Machine;
use crate::targets::{NEEDS, call_depth, elf, flight, limits, progress};

/// Options of `cargo xtask size`.
#[derive(clap::Args)]
pub struct Args {
    /// The actor file.
    file: PathBuf,
}

/// One line of the printed table.
struct Line {
    name: &'static str,
    /// The figure of each build; `None` where it cannot be measured.
    figures: Vec<Option<u64>>,
    /// The largest figure that is allowed.
    limit: Option<u64>,
}

/// Measures the actor file and prints a table with a column for each build.
///
/// # Errors
/// The file is not a valid actor file, a build or a run failed, or a figure is beyond its limit.
pub fn main(args: &Args) -> Result<()> {
    let bytes = fs::read(&args.file).map_err(Error::file(&args.file))?;
    let actor = Actor::load(&bytes).map_err(|reason| Error::content(&args.file, reason.to_string()))?;
    setup::install(NEEDS)?;
    progress("building the images");
    let (emulated, real) = (Image::build(Board::Mps2)?, Image::build(Board::Stm32h743)?);
    elf::assert_panic_free(&emulated.flight)?;
    elf::assert_panic_free(&real.flight)?;

    let step_limit = match actor.aggregation() {
        Aggregation::None | Aggregation::Gcn => limits::STEP_GCN_LIMIT,
        Aggregation::Gat => limits::STEP_GAT_LIMIT,
    };
    let line = |name, limit| Line { name, figures: Vec::new(), limit };
    let mut lines = [
        line("flash: code", Some(limits::CODE_LIMIT)),
        line("flash: constants", None),
        line("flash: actor file", None),
        line("flash: all", None),
        line("static RAM", Some(limits::STATIC_RAM_LIMIT)),
        line("stack, measured", Some(limits::STACK_LIMIT)),
        line("stack, computed", Some(limits::STACK_LIMIT)),
        line("instructions: encode", None),
        line("instructions: one neighbour", None),
        line("instructions: decide", None),
        line("instructions: step, 16 neighbours", Some(step_limit)),
    ];
    let builds =
        [("cortex-m7", Some(Machine::CortexM7)), ("cortex-m4f", Some(Machine::CortexM4f)), ("stm32h743", None)];
    for (name, machine) in builds {
        progress(name);
        let program = if machine.is_some() { &emulated.flight } else { &real.flight };
        let sizes = elf::Sizes::of(program)?;
        let file = bytes.len() as u64;
        let mut column = vec![
            Some(sizes.text),
            Some(sizes.rodata),
            Some(file),
            Some(sizes.text + sizes.rodata + file),
            Some(sizes.static_ram),
        ];
        match machine {
            Some(machine) => {
                column.extend([Some(flight::fly(machine, &emulated, &[&args.file])?), Some(call_depth::of(program)?)]);
                let costs = machine.costs(&emulated, &args.file)?;
                for part in ["encode", "per_neighbour", "decide", "step16"] {
                    column.push(Some(costs.count(part)?));
                }
            }
            None => column.extend([None, Some(call_depth::of(program)?), None, None, None, None]),
        }
        for (line, figure) in lines.iter_mut().zip(column) {
            line.figures.push(figure);
        }
    }
    print(&builds.map(|(name, _)| name), &lines);
    let beyond: Vec<String> = lines.iter().filter(|line| !line.fits()).map(|line| line.name.into()).collect();
    if beyond.is_empty() { Ok(()) } else { Err(Error::Figures(format!("beyond the limit: {}", beyond.join("; ")))) }
}

impl Line {
    /// Whether all figures are within the limit.
    fn fits(&self) -> bool {
        self.limit.is_none_or(|limit| self.figures.iter().flatten().all(|&figure| figure <= limit))
    }
}

/// Prints the table, with the names of the builds at its head.
fn print(builds: &[&str], lines: &[Line]) {
    print!("{:<34}", "bytes, or instructions");
    for build in builds {
        print!("{build:>12}");
    }
    println!("{:>12}", "limit");
    for line in lines {
        print!("{:<34}", line.name);
        for figure in line.figures.iter().copied().chain([line.limit]) {
            print!("{:>12}", figure.map_or_else(|| "–".into(), grouped));
        }
        println!("{}", if line.fits() { "" } else { "  too much" });
    }
}
