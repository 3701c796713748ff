//! Measured figures that are committed to the repository as JSON, and how much they may change.

use std::fs;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// The largest change of an instruction count that is no error, in percent: compilers differ a little.
const TOLERANCE_PERCENT: u64 = 3;

/// Whether a measured instruction count is close enough to the committed one.
pub fn is_close(measured: u64, committed: u64) -> bool {
    100 * measured.abs_diff(committed) <= TOLERANCE_PERCENT * committed
}

/// Formats rows of figures as a JSON array.
pub fn json<T: Serialize>(rows: &[T]) -> String {
    // Plain structs of numbers and text always serialise.
    serde_json::to_string_pretty(rows).unwrap_or_default()
}

/// Reads the committed rows of figures from a JSON file.
///
/// # Errors
/// The file cannot be read, or does not hold such rows.
pub fn read<T: DeserializeOwned>(file: &Path) -> Result<Vec<T>> {
    let text = fs::read_to_string(file).map_err(Error::file(file))?;
    serde_json::from_str(&text).map_err(|error| Error::content(file, format!("{error}; write it with --bless")))
}

/// Writes rows of figures to a JSON file, to be committed.
///
/// # Errors
/// The file cannot be written.
pub fn write<T: Serialize>(file: &Path, rows: &[T]) -> Result<()> {
    fs::write(file, json(rows) + "\n").map_err(Error::file(file))
}

/// Formats a number with commas between its thousands: 1234567 as 1,234,567.
pub fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_may_move_three_in_a_hundred() {
        assert!(is_close(1030, 1000) && is_close(970, 1000));
        assert!(!is_close(1031, 1000) && !is_close(969, 1000));
    }

    #[test]
    fn thousands_are_grouped() {
        for (value, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(grouped(value), text);
        }
    }

    #[test]
    fn figures_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("figures.json");
        write(&file, &[1_u64, 2]).unwrap();
        assert_eq!(read::<u64>(&file).unwrap(), [1, 2]);
        assert!(read::<String>(&file).unwrap_err().to_string().ends_with("write it with --bless"));
    }
}
