//! What `cargo xtask flash` prints while it works.

/// Prints one line of progress.
pub fn say(text: &str) {
    crate::output::show!("flash: {text}");
}
