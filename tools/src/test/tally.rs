//! Counting passed and failed tests in the output of `cargo test`.

/// The numbers of passed and failed tests so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    passed: u64,
    failed: u64,
}

impl Tally {
    /// Reads a line of output. Only the last line of a test program counts, which is of the form
    /// `test result: ok. 5 passed; 0 failed; 1 ignored; …`.
    pub fn read(&mut self, line: &str) {
        let Some((_, counts)) = line.trim().strip_prefix("test result: ").and_then(|rest| rest.split_once(". ")) else {
            return;
        };
        for count in counts.split(';') {
            match count.trim().split_once(' ') {
                Some((number, "passed")) => self.passed += number.parse().unwrap_or(0),
                Some((number, "failed")) => self.failed += number.parse().unwrap_or(0),
                _ => {}
            }
        }
    }

    /// The text `N passed, N failed`. Where no test failed but steps did, as by a build error or a lint, each of
    /// these steps counts as one failure.
    pub fn closing_line(&self, failed_steps: usize) -> String {
        let failed = if self.failed == 0 { failed_steps as u64 } else { self.failed };
        format!("{} passed, {failed} failed", self.passed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(lines: &[&str]) -> Tally {
        let mut tally = Tally::default();
        lines.iter().for_each(|line| tally.read(line));
        tally
    }

    #[test]
    fn results_of_all_test_programs_add_up() {
        let tally = tally(&[
            "running 5 tests",
            "test result: ok. 5 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s",
            "test action::tests::coasting ... ok",
            "test result: FAILED. 7 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.50s",
        ]);
        assert_eq!(tally.closing_line(1), "12 passed, 2 failed");
    }

    #[test]
    fn a_step_that_fails_without_a_failed_test_still_counts() {
        let tally = tally(&["test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out"]);
        assert_eq!(tally.closing_line(0), "3 passed, 0 failed");
        assert_eq!(tally.closing_line(2), "3 passed, 2 failed");
    }

    #[test]
    fn other_lines_do_not_count() {
        assert_eq!(tally(&["test result: nonsense", "4 passed; 4 failed", ""]), Tally::default());
    }
}
