//! `cargo xtask targets`: builds for every target, runs what was built, measures it, and checks the figures.

pub mod artefacts;
pub mod call_depth;
pub mod elf;
pub mod flight;
pub mod limits;
pub mod qemu;
pub mod row;

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::figures;
use crate::setup::{self, Item};
use artefacts::{Actors, Image, Node};
use qemu::Machine;
use row::{Instructions, Row};

/// What must be installed.
pub const NEEDS: &[Item] = &[Item::QemuArm, Item::QemuAarch64, Item::Aarch64Gcc, Item::RustTargets];

/// Neighbourhoods in a signature.
const SIGNATURE_CASES: u32 = firmware_core::actor::SIGNATURE_CASES;
/// Layers that the assembly kernel and its portable twin are compared on.
const KERNEL_CASES: u32 = 3000;

/// Options of `cargo xtask targets`.
#[derive(clap::Args)]
pub struct Args {
    /// Print the rows as a JSON array, and nothing else on the standard output.
    #[arg(long)]
    json: bool,
    /// Commit to today's figures: write docs/targets.json and the table of docs/targets.md.
    #[arg(long)]
    bless: bool,
}

/// Measures every target and prints one table.
///
/// # Errors
/// A build or a run failed, or a figure is not what it should be: all such figures are named.
pub fn main(args: &Args) -> Result<()> {
    setup::install(NEEDS)?;
    let rows = measure()?;
    if args.json {
        println!("{}", figures::json(&rows));
    } else {
        println!("{}", row::table(&rows));
    }
    if args.bless {
        limits::bless(&rows)?;
    }
    let complaints = limits::check(&rows)?;
    if complaints.is_empty() {
        progress("every figure is within its limits");
        return Ok(());
    }
    Err(Error::Figures(complaints.join("\n")))
}

/// Builds, runs and measures everything.
fn measure() -> Result<Vec<Row>> {
    let actors = Actors::make()?;
    let mut rows = Vec::new();
    for node in Node::ALL {
        progress(&format!("node for {} ({})", node.target(), node.profile()));
        let program = node.build()?;
        let sign = |actor: &PathBuf| {
            node.self_test(&program, actor)?;
            node.signature(&program, actor)
        };
        rows.push(row_of(node.target(), node.profile(), actors.signature(sign)?, elf::Sizes::of(&program)?));
    }

    progress("C library for Cortex-M");
    artefacts::c_library()?;
    progress("image for STM32H743");
    let real = Image::build(artefacts::Board::Stm32h743)?;
    check_program(&real.flight)?;
    progress("image for QEMU's mps2");
    let image = Image::build(artefacts::Board::Mps2)?;
    check_program(&image.flight)?;
    // With the safety gate in it.
    elf::assert_panic_free(&image.measure)?;
    let sizes = elf::Sizes::of(&image.flight)?;
    for machine in Machine::ALL {
        progress(&format!("{}: kernel, gate, signature, costs, flight", machine.target()));
        machine.check_kernel(&image, KERNEL_CASES)?;
        machine.check_gate(&image)?;
        let signature = actors.signature(|actor| machine.signature(&image, actor, SIGNATURE_CASES))?;
        let mut row = row_of(machine.target(), "release", signature, sizes);
        let (gcn, gat) = (machine.costs(&image, &actors.gcn)?, machine.costs(&image, &actors.gat)?);
        row.instructions = Instructions::of(&gcn, &gat)?;
        flight::refuses_bad_files(machine, &image, &actors)?;
        row.stack_bytes = Some(flight::fly(machine, &image, &[&actors.none, &actors.gcn, &actors.gat])?);
        rows.push(row);
    }
    Ok(rows)
}

/// Checks what holds for a flight program on any board: no panic, no heap, and no way to a deeper stack than allowed.
fn check_program(program: &Path) -> Result<()> {
    elf::assert_panic_free(program)?;
    let depth = call_depth::of(program)?;
    progress(&format!("stack, computed: {depth} bytes"));
    if depth <= limits::STACK_LIMIT {
        return Ok(());
    }
    Err(Error::content(program, format!("its stack may take {depth} bytes, at most {}", limits::STACK_LIMIT)))
}

fn row_of(target: &str, profile: &str, signature: u64, sizes: elf::Sizes) -> Row {
    Row {
        target: target.into(),
        profile: profile.into(),
        signature: format!("{signature:016x}"),
        text_bytes: sizes.text,
        rodata_bytes: sizes.rodata,
        static_ram_bytes: sizes.static_ram,
        stack_bytes: None,
        instructions: Instructions::default(),
    }
}

/// Says what is going on, beside the result.
pub fn progress(text: &str) {
    eprintln!("targets: {text}");
}
