//! From an interval to a verdict.

use super::statistics::Interval;

/// What a number must be for a claim to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// Greater than this.
    Above(f64),
    /// Less than this.
    Below(f64),
    /// Between these.
    Within(f64, f64),
}

/// What a measurement says of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The whole 95 % interval is on the claim's side of the bar.
    Holds,
    /// The whole interval is on the other side.
    DoesNotHold,
    /// The interval reaches over the bar.
    NotSeparable,
    /// Too few runs, or too short.
    NotMeasured,
}

/// A claim's measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// Mean over seeds and its interval.
    pub interval: Option<Interval>,
    /// Seeds.
    pub seeds: usize,
    /// The verdict.
    pub verdict: Verdict,
}

/// Where an interval lies beside a bar.
#[must_use]
pub fn judge(interval: Option<Interval>, bar: Criterion) -> Verdict {
    let Some(Interval { low, high, .. }) = interval else { return Verdict::NotMeasured };
    let (holds, fails) = match bar {
        Criterion::Above(bar) => (low > bar, high < bar),
        Criterion::Below(bar) => (high < bar, low > bar),
        Criterion::Within(least, most) => (least <= low && high <= most, high < least || most < low),
    };
    match (holds, fails) {
        (true, _) => Verdict::Holds,
        (_, true) => Verdict::DoesNotHold,
        _ => Verdict::NotSeparable,
    }
}

impl Verdict {
    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold",
            Self::NotSeparable => "not separable",
            Self::NotMeasured => "not measured",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_interval_decides() {
        let of = |low, high, bar| judge(Some(Interval { value: (low + high) / 2.0, low, high }), bar);
        assert_eq!(of(0.1, 0.3, Criterion::Above(0.0)), Verdict::Holds);
        assert_eq!(of(-0.3, -0.1, Criterion::Above(0.0)), Verdict::DoesNotHold);
        assert_eq!(of(-0.1, 0.3, Criterion::Above(0.0)), Verdict::NotSeparable);
        assert_eq!(of(0.0, 0.3, Criterion::Above(0.0)), Verdict::NotSeparable);
        assert_eq!(of(-0.3, -0.1, Criterion::Below(0.0)), Verdict::Holds);
        assert_eq!(of(0.1, 0.3, Criterion::Below(0.0)), Verdict::DoesNotHold);
        assert_eq!(of(1.6, 2.4, Criterion::Within(1.5, 2.5)), Verdict::Holds);
        assert_eq!(of(1.4, 2.4, Criterion::Within(1.5, 2.5)), Verdict::NotSeparable);
        assert_eq!(of(2.6, 2.9, Criterion::Within(1.5, 2.5)), Verdict::DoesNotHold);
        assert_eq!(judge(None, Criterion::Above(0.0)), Verdict::NotMeasured);
    }
}
