//! `cargo xtask targets`: builds for every target, runs and measures what was built, and checks the figures.

pub mod artefacts;
pub mod call_depth;
pub mod elf;
pub mod flight;
pub mod limits;
pub mod qemu;
pub mod row;

use std::path::{Path, PathBuf};

use firmware_core::actor::FINGERPRINT_CASES;

use crate::error::{Error, Result};
use crate::figures;
use crate::output::{print, tell};
use crate::setup::{self, Item};
use artefacts::{Actors, Image, Node};
use qemu::Machine;
use row::{Instructions, Row};

/// What must be installed to build for the targets and to run what was built.
pub const NEEDS: &[Item] = &[Item::QemuArm, Item::QemuAarch64, Item::Aarch64Gcc, Item::RustTargets];

/// Layers on which the assembly kernel is compared with the portable one.
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

/// Measures every target, prints a table and checks the figures.
///
/// # Errors
/// A build or a run failed, or figures are not what they should be; the error names all of them.
pub fn main(args: &Args) -> Result<()> {
    setup::install(NEEDS)?;
    let rows = measure()?;
    let text = if args.json { figures::json(&rows) } else { row::table(&rows) };
    print(&format!("{text}\n"))?;
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

/// Builds, runs and measures everything, and returns a row of figures for each build.
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
    // The measuring program contains the safety gate, which the flight program does not.
    elf::assert_panic_free(&image.measure)?;
    let sizes = elf::Sizes::of(&image.flight)?;
    for machine in Machine::ALL {
        progress(&format!("{}: kernel, gate, signature, costs, flight", machine.target()));
        machine.check_kernel(&image, KERNEL_CASES)?;
        machine.check_gate(&image)?;
        let signature = actors.signature(|actor| machine.signature(&image, actor, FINGERPRINT_CASES))?;
        let mut row = row_of(machine.target(), "release", signature, sizes);
        let costs = |actor| machine.costs(&image, actor);
        let [gcn, gat] = [costs(&actors.gcn)?, costs(&actors.gat)?];
        let [gatv2, sage] = [costs(&actors.gatv2)?, costs(&actors.sage)?];
        row.instructions = Instructions::of([&gcn, &gat, &gatv2, &sage])?;
        flight::refuses_bad_files(machine, &image, &actors)?;
        row.stack_bytes = Some(flight::fly(machine, &image, &actors.all().map(PathBuf::as_path))?);
        rows.push(row);
    }
    Ok(rows)
}

/// Checks what must hold for the flight program on every board: no panic, no heap, and a computed stack within the
/// limit.
fn check_program(program: &Path) -> Result<()> {
    elf::assert_panic_free(program)?;
    let depth = call_depth::of(program)?;
    progress(&format!("stack, computed: {depth} bytes"));
    if depth <= limits::STACK_LIMIT {
        return Ok(());
    }
    Err(Error::content(program, format!("its stack may take {depth} bytes, at most {}", limits::STACK_LIMIT)))
}

/// The row of a build, without stack and instructions, which only the Cortex-M builds have.
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

/// Prints a line of progress on the error output, apart from the result.
pub fn progress(text: &str) {
    tell!("targets: {text}");
}
