//! Another program's measurement, in turns with one's own.

use super::median::median;
use miette::{Diagnostic, Result};
use serde::Serialize;
use std::process::{Command, Stdio};
use thiserror::Error;

/// What rates are called where nothing else is said: the first that is found counts.
const MARKERS: [&str; 2] = ["agent_steps_per_s", "rate"];

/// Why another program's rate is not known.
#[derive(Debug, Diagnostic, Error)]
pub enum AgainstError {
    /// It did not start.
    #[error("cannot run `{command}`: {error}")]
    Start {
        /// The command.
        command: String,
        /// Why.
        error: std::io::Error,
    },
    /// It failed.
    #[error("`{command}` failed: {status}; run it by itself to see why")]
    Failed {
        /// The command.
        command: String,
        /// How.
        status: std::process::ExitStatus,
    },
    /// Its output has no rate.
    #[error("`{command}` printed no number after `{marker}`; say with --marker what stands before its rate")]
    NoRate {
        /// The command.
        command: String,
        /// What was looked for.
        marker: String,
    },
}

/// Two programs in turn: agent-steps a second, pair by pair.
#[derive(Clone, Debug, Serialize)]
pub struct Turns {
    /// The other program.
    pub command: String,
    /// Its rates.
    pub rates: Vec<f64>,
    /// The trainer's, each just before.
    pub own_rates: Vec<f64>,
    /// Median of the ratios, own over other.
    pub ratio: f64,
}

/// Lets them take turns `pairs` times; `own` measures the trainer. The other's rate is the last
/// number after `marker`.
///
/// # Errors
/// See [`AgainstError`].
pub fn take_turns(command: &str, marker: Option<&str>, pairs: u32, mut own: impl FnMut() -> f64) -> Result<Turns> {
    let (mut rates, mut own_rates) = (Vec::new(), Vec::new());
    for _ in 0..pairs.max(1) {
        own_rates.push(own());
        rates.push(rate_of(command, marker)?);
    }
    let ratio = median(own_rates.iter().zip(&rates).map(|(own, other)| own / other).collect());
    Ok(Turns { command: command.to_owned(), rates, own_rates, ratio })
}

/// Runs the command by the shell and reads its rate; its error output is shown.
fn rate_of(command: &str, marker: Option<&str>) -> Result<f64, AgainstError> {
    let shell = Command::new("sh").args(["-c", command]).stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let output = shell.map_err(|error| AgainstError::Start { command: command.to_owned(), error })?;
    if !output.status.success() {
        return Err(AgainstError::Failed { command: command.to_owned(), status: output.status });
    }
    let printed = String::from_utf8_lossy(&output.stdout);
    let markers = marker.as_ref().map_or(&MARKERS[..], std::slice::from_ref);
    markers
        .iter()
        .find_map(|marker| last_number(&printed, marker))
        .ok_or_else(|| AgainstError::NoRate { command: command.to_owned(), marker: markers.join("` or `") })
}

/// The first number after the last `marker`.
fn last_number(text: &str, marker: &str) -> Option<f64> {
    let (_, rest) = text.rsplit_once(marker)?;
    let start = rest.find(|c: char| c.is_ascii_digit())?;
    let number: String = rest[start..].chars().take_while(|c| c.is_ascii_digit() || ".eE+".contains(*c)).collect();
    number.trim_end_matches(['.', 'e', 'E', '+']).parse().ok().filter(|&rate| rate > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_rate_counts() {
        let text = r#"warm-up agent_steps_per_s=1
            {"train": {"rate": 64729, "us": 15.4}, "agent_steps_per_s": 1.5e3}."#;
        assert_eq!(last_number(text, "agent_steps_per_s"), Some(1500.0));
        assert_eq!(last_number(text, "\"train\": {\"rate\""), Some(64729.0));
        assert_eq!(last_number("rate: 12.", "rate"), Some(12.0));
        assert_eq!(last_number("rate: 0", "rate"), None);
        assert_eq!(last_number("rate: none", "rate"), None);
        assert_eq!(last_number("", "rate"), None);
    }

    #[test]
    fn a_program_without_a_rate_is_named() {
        let turns = take_turns("echo rate 50", None, 3, || 100.0).expect("rates");
        assert_eq!((turns.ratio, turns.rates.len(), turns.own_rates.len()), (2.0, 3, 3));
        let both = "echo rate 50; echo agent_steps_per_s=25";
        assert_eq!(take_turns(both, None, 1, || 100.0).expect("rates").ratio, 4.0);
        assert_eq!(take_turns(both, Some("rate"), 1, || 100.0).expect("rates").ratio, 2.0);
        let message = |command| take_turns(command, Some("rate"), 1, || 1.0).expect_err("no rate").to_string();
        assert!(message("echo nothing").contains("no number after `rate`"));
        let any = take_turns("true", None, 1, || 1.0).expect_err("no rate").to_string();
        assert!(any.contains("after `agent_steps_per_s` or `rate`"), "{any}");
        assert!(message("exit 3").contains("failed"));
    }
}
