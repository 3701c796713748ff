//! Puts the board's memory map where the linker looks for it.
//!
//! `COVEY_ACTOR_ADDRESS` moves the actor file, for example to another flash sector: `0x08040000`.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=memory");
    println!("cargo::rerun-if-env-changed=COVEY_ACTOR_ADDRESS");
    let has = |board: &str| env::var_os(format!("CARGO_FEATURE_{board}")).is_some();
    let board = match (has("MPS2"), has("STM32H743")) {
        (true, false) => "mps2",
        (false, true) => "stm32h743",
        _ => return println!("cargo::error=choose one board: --features mps2 or --features stm32h743"),
    };
    let map = fs::read_to_string(format!("memory/{board}.x")).expect("the board's memory map");
    let map = match env::var("COVEY_ACTOR_ADDRESS") {
        Ok(address) => move_actor(&map, &address),
        Err(_) => map,
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::write(out.join("memory.x"), map).expect("OUT_DIR can be written");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=--nmagic");
}

/// The map with its `ACTOR` region at `address`.
fn move_actor(map: &str, address: &str) -> String {
    let moved = |line: &str| match line.split_once("ORIGIN = ") {
        Some((before, after)) if line.trim_start().starts_with("ACTOR") => {
            let (_, rest) = after.split_once(',').expect("ORIGIN = address, LENGTH = length");
            format!("{before}ORIGIN = {address},{rest}")
        }
        _ => line.to_owned(),
    };
    map.lines().map(|line| moved(line) + "\n").collect()
}
