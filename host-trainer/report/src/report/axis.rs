//! Axes: where values are on them, and round numbers for their ticks.

use super::number::number;

/// One axis of a chart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// From the lowest to the highest value, with about `ticks` ticks inside.
    pub fn exact((low, high): (f64, f64), ticks: u32) -> Self {
        let (low, high) = widened(low, high);
        let step = round_step((high - low) / f64::from(ticks));
        // Rounded up beyond the whole range, a step may have no multiple inside it.
        let step = if step > high - low { round_step(0.3 * step) } else { step };
        Self { low, high, step }
    }

    /// As [`Axis::exact`], but an end just short of a tick is lengthened to it.
    pub fn snapped(range: (f64, f64), ticks: u32) -> Self {
        let exact @ Self { low, high, step } = Self::exact(range, ticks);
        let covering = Self::covering(range, ticks);
        let near = |tick: f64, end: f64| if (tick - end).abs() <= 0.1 * step { tick } else { end };
        Self { low: near(covering.low, low), high: near(covering.high, high), ..exact }
    }

    /// As [`Axis::exact`], lengthened so that both ends are ticks.
    pub fn covering(range: (f64, f64), ticks: u32) -> Self {
        let Self { low, high, step } = Self::exact(range, ticks);
        // The slack keeps an end that is a tick but for rounding from adding another.
        Self { low: (low / step + 1e-9).floor() * step, high: (high / step - 1e-9).ceil() * step, step }
    }

    pub fn low(&self) -> f64 {
        self.low
    }

    pub fn high(&self) -> f64 {
        self.high
    }

    /// Where a value is on the axis: 0 at the low end, 1 at the high end.
    pub fn fraction(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// The round values on the axis.
    pub fn ticks(&self) -> impl Iterator<Item = f64> {
        let (low, high, step) = (self.low, self.high, self.step);
        let first = (low / step - 1e-9).ceil();
        (0..32).map(move |i| (first + f64::from(i)) * step).take_while(move |t| *t <= high + 1e-9 * step)
    }

    /// A tick's text: as many decimals as the step needs.
    pub fn label(&self, tick: f64) -> String {
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        if decimals > 5 || self.high.abs().max(self.low.abs()) >= 1e7 {
            return if tick == 0.0 { "0".into() } else { format!("{tick:.0e}").replace('-', "−") };
        }
        number(tick, decimals)
    }
}

/// Lowest and highest finite value; 0 to 1 when there is none.
pub(super) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let mut range: Option<(f64, f64)> = None;
    for v in values.filter(|v| v.is_finite()) {
        let (low, high) = range.unwrap_or((v, v));
        range = Some((low.min(v), high.max(v)));
    }
    range.unwrap_or((0.0, 1.0))
}

/// Ends that differ and whose difference does not overflow.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let (low, high) = (low.clamp(-1e300, 1e300), high.clamp(-1e300, 1e300));
    if high - low > low.abs().max(high.abs()) * 1e-9 && high - low > 1e-300 {
        return (low, high);
    }
    let margin = if low == 0.0 { 1.0 } else { low.abs() * 0.1 };
    (low - margin, high + margin)
}

/// 1, 2 or 5 times a power of ten, not below `raw`.
fn round_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    match raw / power {
        m if m <= 1.0 => power,
        m if m <= 2.0 => 2.0 * power,
        m if m <= 5.0 => 5.0 * power,
        _ => 10.0 * power,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(axis: Axis) -> Vec<String> {
        axis.ticks().map(|t| axis.label(t)).collect()
    }

    #[test]
    fn ticks_are_round_and_labelled_with_the_decimals_they_need() {
        assert_eq!(labels(Axis::covering((0.13, 0.58), 5)), ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
        assert_eq!(labels(Axis::exact((0.0, 6000.0), 4)), ["0", "2,000", "4,000", "6,000"]);
        assert_eq!(labels(Axis::snapped((6.0, 5990.0), 4)), ["0", "2,000", "4,000", "6,000"]);
        assert_eq!(labels(Axis::snapped((900.0, 5000.0), 4)), ["2,000", "4,000"]);
        assert_eq!(labels(Axis::covering((-0.013, 0.004), 4)), ["−0.015", "−0.010", "−0.005", "0.000", "0.005"]);
        assert_eq!(labels(Axis::covering((0.0, 3e-7), 3)), ["0", "1e−7", "2e−7", "3e−7"]);
        assert_eq!(labels(Axis::covering((0.3, 0.3), 2)), ["0.25", "0.30", "0.35"]);
    }

    #[test]
    fn a_range_shorter_than_its_rounded_step_has_a_tick() {
        for (low, high) in [(-4.58, -0.29), (-4.583870523906242e-81, -2.943432413207027e-82)] {
            assert!(Axis::exact((low, high), 2).ticks().count() >= 1, "{low} to {high}");
        }
    }

    proptest! {
        #[test]
        fn any_range_gives_a_few_ticks_inside_it(a in any::<f64>(), b in any::<f64>(), n in 2u32..8) {
            let range = range([a, b].into_iter());
            for axis in [Axis::exact(range, n), Axis::snapped(range, n), Axis::covering(range, n)] {
                let ticks: Vec<_> = axis.ticks().collect();
                prop_assert!((1..=24).contains(&ticks.len()), "{axis:?}: {ticks:?}");
                for t in ticks {
                    prop_assert!((-1e-6..=1.0 + 1e-6).contains(&axis.fraction(t)), "{axis:?}: {t}");
                }
            }
        }
    }
}
