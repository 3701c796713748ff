//! `COVEY_HOLD_AT`, for tests: holds the program at a stated point, so that a test can do something there
//! however fast or busy the machine is.
//!
//! `COVEY_HOLD_AT=round:2:PATH` holds a run when its round 2 has ended and its row of metrics is written;
//! `COVEY_HOLD_AT=measuring:PATH` when its training has ended, and holds the other commands before they measure or draw. Held, the program says so on standard error and reads the pipe (FIFO) at PATH
//! until its writer closes it. It can then go on; a run that is held again has to be let go again.

use super::output::tell;
use miette::{Result, miette};
use std::path::PathBuf;

/// The variable's name.
const VARIABLE: &str = "COVEY_HOLD_AT";

/// A point at which a run can be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Point {
    Round(u32),
    Measuring,
}

/// Where this process is held, if anywhere.
#[derive(Debug, Default)]
pub struct Hold(Option<(Point, PathBuf)>);

impl Hold {
    /// As the environment says.
    ///
    /// # Errors
    /// When the variable is set to something else than a point and a path.
    pub fn from_environment() -> Result<Self> {
        let Some(text) = std::env::var_os(VARIABLE) else { return Ok(Self::default()) };
        let text = text.to_string_lossy();
        let found = parse(&text);
        let wrong = || miette!("{VARIABLE}={text}: write round:N:PATH or measuring:PATH, or unset it");
        Ok(Self(Some(found.ok_or_else(wrong)?)))
    }

    /// Holds a command that measures, or makes pages, before it does.
    ///
    /// # Errors
    /// As [`Self::from_environment`].
    pub fn before_measuring() -> Result<()> {
        Self::from_environment()?.at_measuring();
        Ok(())
    }

    /// Called when `round` rounds have ended.
    pub fn at_round(&self, round: u32) {
        self.at(Point::Round(round));
    }

    /// Called before something is measured.
    pub fn at_measuring(&self) {
        self.at(Point::Measuring);
    }

    fn at(&self, point: Point) {
        if let Some((held_at, path)) = &self.0
            && *held_at == point
        {
            tell!("held at {point:?}");
            // A pipe that cannot be read holds nothing; the test that made it notices.
            let _ = std::fs::read(path);
        }
    }
}

fn parse(text: &str) -> Option<(Point, PathBuf)> {
    let (point, rest) = text.split_once(':')?;
    let (point, path) = match point {
        "round" => {
            let (number, path) = rest.split_once(':')?;
            (Point::Round(number.parse().ok()?), path)
        }
        "measuring" => (Point::Measuring, rest),
        _ => return None,
    };
    (!path.is_empty()).then(|| (point, PathBuf::from(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read() {
        assert_eq!(parse("round:2:/a:b"), Some((Point::Round(2), "/a:b".into())));
        assert_eq!(parse("measuring:p"), Some((Point::Measuring, "p".into())));
        for wrong in ["", "round:2", "round:x:p", "measuring", "measuring:", "end:p"] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
