//! What several runs of the same settings tell: means, interquartile means and intervals.

use covey_env::random::{below, stream};

/// Resamples of a bootstrap: a handful of runs has only hundreds of different ones.
pub const RESAMPLES: u32 = 2000;

/// A value and the ends of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Low end.
    pub low: f64,
    /// High end.
    pub high: f64,
}

/// Arithmetic mean; not a number when there are no values.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean of the middle half: the ⌊n/4⌋ lowest and as many of the highest are left out.
#[must_use]
pub fn interquartile_mean(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// The mean of independent values and its 95 % interval by Student's t with n − 1 degrees of
/// freedom; none for fewer than two values.
#[must_use]
pub fn student(values: &[f64]) -> Option<Interval> {
    let n = values.len();
    if n < 2 || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let value = mean(values);
    let squares: f64 = values.iter().map(|v| (v - value).powi(2)).sum();
    let half = t975(n - 1) * (squares / (n - 1) as f64 / n as f64).sqrt();
    Some(Interval { value, low: value - half, high: value + half })
}

/// 0.975 quantile of Student's t with `freedom` degrees of freedom.
fn t975(freedom: usize) -> f64 {
    const EXACT: [f64; 30] = [
        12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281, 2.2010, 2.1788, 2.1604,
        2.1448, 2.1314, 2.1199, 2.1098, 2.1009, 2.0930, 2.0860, 2.0796, 2.0739, 2.0687, 2.0639, 2.0595, 2.0555, 2.0518,
        2.0484, 2.0452, 2.0423,
    ];
    // Beyond the table Fisher's expansion around the normal quantile is as exact.
    let (z, f) = (1.959_964f64, freedom as f64);
    let far = z + (z.powi(3) + z) / (4.0 * f) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * f * f);
    EXACT.get(freedom.wrapping_sub(1)).copied().unwrap_or(far)
}

/// A statistic of the items and its 95 % percentile interval from resamples of whole items,
/// drawn with replacement from the stream of the name `name`: the same at every call. None for
/// fewer than two items.
///
/// An item is all that varies together, such as a run with all its measurements: resampling
/// these apart would take them for independent.
pub fn bootstrap<T>(items: &[T], name: &str, statistic: impl Fn(&[&T]) -> f64) -> Option<Interval> {
    if items.len() < 2 {
        return None;
    }
    let mut rng = stream(name, 0, 0);
    let n = items.len() as u32;
    let mut found: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn: Vec<&T> = items.iter().map(|_| &items[below(&mut rng, n) as usize]).collect();
            statistic(&drawn)
        })
        .collect();
    found.sort_by(f64::total_cmp);
    let value = statistic(&items.iter().collect::<Vec<_>>());
    Some(Interval { value, low: quantile(&found, 0.025), high: quantile(&found, 0.975) })
}

/// Interquartile mean over runs with its bootstrap interval over runs.
#[must_use]
pub fn interquartile(values: &[f64]) -> Option<Interval> {
    bootstrap(values, "interquartile mean", |v| {
        let values: Vec<f64> = v.iter().map(|v| **v).collect();
        interquartile_mean(&values)
    })
}

/// Quantile of sorted values, linear between neighbours.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (low, part) = (at.floor() as usize, at.fract());
    let high = sorted[(low + 1).min(sorted.len() - 1)];
    sorted[low] + part * (high - sorted[low])
}

/// Least-squares slope of y over x.
#[must_use]
pub fn slope(points: &[(f64, f64)]) -> f64 {
    line(points).1
}

/// Sample deviation of y around the least-squares line over x; not a number for fewer than
/// three points.
#[must_use]
pub fn scatter_around_line(points: &[(f64, f64)]) -> f64 {
    if points.len() < 3 {
        return f64::NAN;
    }
    let (level, slope) = line(points);
    let squares: f64 = points.iter().map(|(x, y)| (y - level - slope * x).powi(2)).sum();
    (squares / (points.len() as f64 - 2.0)).sqrt()
}

fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let products: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let squares: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let slope = products / squares;
    (y - slope * x, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn close(a: f64, b: f64, within: f64) -> bool {
        (a - b).abs() <= within
    }

    #[test]
    fn the_interquartile_mean_leaves_a_quarter_out_at_each_end() {
        assert_eq!(interquartile_mean(&[9.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!(interquartile_mean(&[1.0, 2.0, 3.0, 4.0, 100.0]), 3.0);
        assert_eq!(interquartile_mean(&[8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]), 4.5);
        assert_eq!(interquartile_mean(&[1.0, 2.0, 6.0]), 3.0);
    }

    /// Five values of mean 3 and deviation √2.5: 2.7764 · √(2.5/5) = 1.9632.
    #[test]
    fn students_interval_is_that_of_the_textbook() {
        let found = student(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_eq!(found.value, 3.0);
        assert!(close(found.low, 1.0368, 1e-4) && close(found.high, 4.9632, 1e-4), "{found:?}");
        assert_eq!(student(&[1.0]), None);
        assert_eq!(student(&[1.0, f64::NAN]), None);
        assert!(close(t975(40), 2.0211, 2e-4) && close(t975(120), 1.9799, 2e-4) && close(t975(31), 2.0395, 2e-4));
    }

    /// Of two values a resample's mean is low, middle or high with shares ¼, ½, ¼.
    #[test]
    fn the_bootstrap_of_two_values_reaches_both() {
        let found = bootstrap(&[0.0, 1.0], "test", |v| v.iter().copied().sum::<f64>() / 2.0).unwrap();
        assert_eq!(found, Interval { value: 0.5, low: 0.0, high: 1.0 });
    }

    /// Many values: the interval nears the normal one of the mean, ± 1.96 σ/√n.
    #[test]
    fn the_bootstrap_of_many_values_is_the_normal_interval() {
        let values: Vec<f64> = (0..400).map(|k| f64::from(k % 20)).collect();
        let found = bootstrap(&values, "test", |v| v.iter().copied().sum::<f64>() / v.len() as f64).unwrap();
        let half = 1.96 * (399.0f64 / 12.0).sqrt() / 20.0;
        assert!(close(found.high - found.value, half, 0.08 * half), "{found:?} ± {half}");
        assert!(close(found.value - found.low, half, 0.08 * half), "{found:?} ± {half}");
        assert_eq!(interquartile(&values), interquartile(&values));
    }

    #[test]
    fn lines_and_what_is_left_around_them() {
        assert_eq!(slope(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]), 2.0);
        assert_eq!(scatter_around_line(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]), 0.0);
        assert!(scatter_around_line(&[(0.0, 1.0), (1.0, 3.0)]).is_nan());
        assert!(close(scatter_around_line(&[(0.0, 1.0), (1.0, -1.0), (2.0, -1.0), (3.0, 1.0)]), 2f64.sqrt(), 1e-12));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn intervals_hold_their_values(values in proptest::collection::vec(-1e3..1e3f64, 2..12)) {
            for found in [student(&values), interquartile(&values)].into_iter().flatten() {
                prop_assert!(found.low <= found.value + 1e-9 && found.value <= found.high + 1e-9, "{found:?}");
            }
        }
    }
}
