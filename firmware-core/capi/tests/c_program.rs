//! Compiles a C program against the header and the static library, runs it here and on QEMU's Cortex-M boards, and
//! compares what it prints with what the same calls give in Rust.

#[path = "../../tests/common/mod.rs"]
mod common;
mod expected;

use common::sample_actor;
use covey_capi::Status;
use expected::{CORTEX_M, HERE, Pointers};
use firmware_core::actor::Aggregation;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

const HEADER: &str = include_str!("../include/covey.h");
/// Where `cargo xtask targets` puts the library for Cortex-M, in cargo's target folder.
const CORTEX_M_LIBRARY: &str = "targets/capi/thumbv7em-none-eabihf/firmware/libcovey_capi.a";

/// Cargo builds the static library together with the one that this test links, beside the
/// test's own binary. Older builds may lie there too: the newest is of the present code.
fn library() -> PathBuf {
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let entries = std::fs::read_dir(&deps).unwrap().map(|entry| entry.unwrap());
    let is_library = |name: &str| name.starts_with("libcovey_capi") && name.ends_with(".a");
    entries
        .filter(|entry| is_library(&entry.file_name().to_string_lossy()))
        .max_by_key(|entry| entry.metadata().unwrap().modified().unwrap())
        .unwrap_or_else(|| panic!("no static library in {}", deps.display()))
        .path()
}

fn cortex_m_library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let library = test.ancestors().nth(3).unwrap().join(CORTEX_M_LIBRARY);
    assert!(library.is_file(), "no library at {}: `cargo xtask targets` builds it", library.display());
    library
}

/// Runs a command to its good end and returns all that it printed.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}; `cargo xtask setup` installs it"));
    // What a program on an emulated board prints comes on the emulator's error output.
    let printed = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(output.status.success(), "{command:?}\n{printed}");
    printed
}

/// Compiles `flight.c` and links it with `library`.
fn compile(compiler: &mut Command, library: &Path, program: &Path) {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    run(compiler
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-I"])
        .arg(here.join("include"))
        .arg(here.join("tests/flight.c"))
        .arg(library)
        .args(["-lm", "-o"])
        .arg(program));
}

/// Flies one actor of each kind; `start` runs the program on the file `sample.actor` of the folder `work`.
fn assert_flies(work: &Path, pointers: &Pointers, start: impl Fn() -> String) {
    for (aggregation, seed) in Aggregation::ALL.into_iter().zip(1..) {
        let file = sample_actor(aggregation, seed);
        std::fs::write(work.join("sample.actor"), &file).unwrap();
        let (printed, expected) = (start(), expected::output(pointers, &file));
        for (number, (got, want)) in printed.lines().zip(expected.lines()).enumerate() {
            assert_eq!(got, want, "line {}", number + 1);
        }
        assert_eq!(printed.lines().count(), expected.lines().count());
    }
}

#[test]
fn a_c_program_flies_as_rust_does() {
    let work = tempfile::tempdir().unwrap();
    let program = work.path().join("flight");
    let mut compiler = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compile(compiler.args(["-pthread", "-ldl"]), &library(), &program);
    assert_flies(work.path(), &HERE, || run(Command::new(&program).arg("sample.actor").current_dir(work.path())));
}

#[test]
#[ignore = "needs the library, a compiler and an emulator for Cortex-M: `cargo xtask test` has them and runs this"]
fn a_c_program_flies_on_cortex_m_as_rust_does_here() {
    let work = tempfile::tempdir().unwrap();
    let program = work.path().join("flight.elf");
    compile(
        Command::new("arm-none-eabi-gcc")
            .args(["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"])
            // Files, the command line and what is printed go through the emulator.
            .args(["--specs=picolibc.specs", "--oslib=semihost", "--crt0=semihost"])
            // The boards' memory, as picolibc names it.
            .args(
                ["flash=0", "flash_size=4M", "ram=0x20000000", "ram_size=4M"].map(|it| format!("-Wl,--defsym=__{it}")),
            )
            .arg("-Wl,-z,noexecstack"),
        &cortex_m_library(),
        &program,
    );
    for board in ["mps2-an500", "mps2-an386"] {
        assert_flies(work.path(), &CORTEX_M, || {
            run(Command::new("qemu-system-arm")
                .args(["-machine", board, "-nographic", "-monitor", "none", "-serial", "null", "-kernel"])
                .arg(&program)
                .args(["-semihosting-config", "enable=on,target=native,arg=sample.actor"])
                .current_dir(work.path()))
        });
    }
}

#[test]
#[ignore = "needs the library for Cortex-M: `cargo xtask test` has it and runs this"]
fn neither_panic_nor_heap_is_left_in_the_library_for_cortex_m() {
    let library = std::fs::read(cortex_m_library()).unwrap();
    let holds = |name: &str| library.windows(name.len()).any(|bytes| bytes == name.as_bytes());
    assert!(holds("covey_decide"));
    for name in ["panic", "unwrap_failed", "__rust_alloc", "malloc"] {
        assert!(!holds(name), "{name}");
    }
}

/// `covey_…` before each `(` in a text, where `before` stands in front.
fn functions(text: &str, before: &str) -> BTreeSet<String> {
    let starts = text.match_indices(before).map(|(at, _)| &text[at + before.len()..]);
    starts.filter_map(|rest| rest.split_once('(')).map(|(name, _)| name.to_owned()).collect()
}

#[test]
fn header_and_library_have_the_same_functions() {
    let sources = [
        include_str!("../src/actor.rs"),
        include_str!("../src/navigation.rs"),
        include_str!("../src/scene.rs"),
        include_str!("../src/status.rs"),
    ];
    let exported = functions(&sources.concat(), "extern \"C\" fn ");
    let declared: BTreeSet<String> = HEADER
        .lines()
        .filter(|l| !l.starts_with(' ') && l.contains('(') && l.contains(" covey_") || l.contains("*covey_"))
        .filter_map(|l| l.split_once('(')?.0.rsplit([' ', '*']).next().map(str::to_owned))
        .collect();
    assert_eq!(declared, exported);
    assert_eq!(exported.len(), 16);
}

#[test]
fn every_status_has_a_text_of_its_own() {
    let texts: BTreeSet<_> = Status::ALL.iter().map(|(_, text)| text).collect();
    assert_eq!(texts.len(), Status::ALL.len());
    let numbers: BTreeSet<_> = Status::ALL.iter().map(|&(status, _)| status as i32).collect();
    assert_eq!(numbers.len(), Status::ALL.len());
}
