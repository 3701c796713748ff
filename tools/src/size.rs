//! `cargo xtask size FILE`: flash, RAM, stack and instructions of an actor file on a flight controller, and whether
//! they are within the limits.

use std::fs;
use std::path::{Path, PathBuf};

use firmware_core::actor::{Actor, Aggregation};

use crate::error::{Error, Result};
use crate::figures::grouped;
use crate::output;
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

    let builds =
        [("cortex-m7", Some(Machine::CortexM7)), ("cortex-m4f", Some(Machine::CortexM4f)), ("stm32h743", None)];
    let mut lines = lines(actor.aggregation());
    for (name, machine) in builds {
        progress(name);
        let image = if machine.is_some() { &emulated } else { &real };
        let figures = measure(machine, image, &args.file, bytes.len() as u64)?;
        for (line, figure) in lines.iter_mut().zip(figures) {
            line.figures.push(figure);
        }
    }
    print(&builds.map(|(name, _)| name), &lines)?;
    let beyond: Vec<String> = lines.iter().filter(|line| !line.fits()).map(|line| line.name.into()).collect();
    if beyond.is_empty() { Ok(()) } else { Err(Error::Figures(format!("beyond the limit: {}", beyond.join("; ")))) }
}

/// The lines of the table, still without figures.
fn lines(aggregation: Aggregation) -> [Line; 11] {
    let step_limit = match aggregation {
        Aggregation::None | Aggregation::Gcn | Aggregation::Sage => limits::STEP_GCN_LIMIT,
        Aggregation::Gat => limits::STEP_GAT_LIMIT,
        Aggregation::GatV2 => limits::STEP_GATV2_LIMIT,
    };
    [
        ("flash: code", Some(limits::CODE_LIMIT)),
        ("flash: constants", None),
        ("flash: actor file", None),
        ("flash: all", None),
        ("static RAM", Some(limits::STATIC_RAM_LIMIT)),
        ("stack, measured", Some(limits::STACK_LIMIT)),
        ("stack, computed", Some(limits::STACK_LIMIT)),
        ("instructions: encode", None),
        ("instructions: one neighbour", None),
        ("instructions: decide", None),
        ("instructions: step, 16 neighbours", Some(step_limit)),
    ]
    .map(|(name, limit)| Line { name, figures: Vec::new(), limit })
}

/// The figures of one build, in the order of the lines. `machine` is the emulated board that runs the image, if any.
fn measure(machine: Option<Machine>, image: &Image, file: &Path, file_bytes: u64) -> Result<Vec<Option<u64>>> {
    let sizes = elf::Sizes::of(&image.flight)?;
    let flash = sizes.text + sizes.rodata + file_bytes;
    let mut figures = vec![Some(sizes.text), Some(sizes.rodata), Some(file_bytes), Some(flash), Some(sizes.static_ram)];
    match machine {
        Some(machine) => {
            figures.extend([Some(flight::fly(machine, image, &[file])?), Some(call_depth::of(&image.flight)?)]);
            let costs = machine.costs(image, file)?;
            for part in ["encode", "per_neighbour", "decide", "step16"] {
                figures.push(Some(costs.count(part)?));
            }
        }
        None => figures.extend([None, Some(call_depth::of(&image.flight)?), None, None, None, None]),
    }
    Ok(figures)
}

impl Line {
    /// Whether all figures are within the limit.
    fn fits(&self) -> bool {
        self.limit.is_none_or(|limit| self.figures.iter().flatten().all(|&figure| figure <= limit))
    }
}

/// Prints the table, with the names of the builds at its head.
///
/// # Errors
/// Standard output takes nothing.
fn print(builds: &[&str], lines: &[Line]) -> Result<()> {
    let mut text = format!("{:<34}", "bytes, or instructions");
    text.extend(builds.iter().map(|build| format!("{build:>12}")));
    text += &format!("{:>12}\n", "limit");
    for line in lines {
        text += &format!("{:<34}", line.name);
        for figure in line.figures.iter().copied().chain([line.limit]) {
            text += &format!("{:>12}", figure.map_or_else(|| "–".into(), grouped));
        }
        text += if line.fits() { "\n" } else { "  too much\n" };
    }
    output::print(&text)
}
