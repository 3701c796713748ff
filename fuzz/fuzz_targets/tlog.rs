#![no_main]

#[path = "../bridge_checks.rs"]
#[allow(dead_code)] // Each target runs one of them.
mod checks;

libfuzzer_sys::fuzz_target!(|data: &[u8]| checks::tlog(data));
