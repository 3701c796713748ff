//! Command line of the trainer.

use clap::Parser;
use host_trainer::cli::{Cli, with_current_names};
use host_trainer::commands;

fn main() -> miette::Result<()> {
    tune_process();
    // Lines are not broken: commands and paths in messages can be copied. It fails only
    // where a hook is set already.
    let _ = miette::set_hook(Box::new(|_| Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())));
    let (arguments, renamed) = with_current_names(std::env::args_os());
    renamed.iter().for_each(|flag| commands::write_err(format_args!("{flag}")));
    commands::run(&Cli::parse_from(arguments).command)
}

/// Large tensors come and go thousands of times a second: glibc must not hand their
/// memory back each time.
fn tune_process() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: called before any thread starts, with documented parameters.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 30);
        libc::mallopt(libc::M_TRIM_THRESHOLD, i32::MAX);
        libc::mallopt(libc::M_TOP_PAD, 64 << 20);
    }
}
