//! Chooses the assembly kernel: Cortex-M4 and M7 (ARMv7E-M) have SMLAD.
//!
//! By target name, because stable compilers do not show `target_feature = "dsp"`.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(smlad)");
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv7em")) {
        println!("cargo::rustc-cfg=smlad");
    }
}
