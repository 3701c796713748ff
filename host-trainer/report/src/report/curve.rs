//! Charts turned into SVG paths, for the page and for single pictures alike.

use std::fmt::Write;

use super::axis::{Axis, range};
use super::chart::{Chart, Series};

/// Longer curves are thinned: more points cannot be seen on a screen.
const MOST_POINTS: usize = 600;

/// A chart's axes.
pub(super) struct Axes {
    pub x: Axis,
    pub y: Axis,
}

impl Axes {
    pub fn of(chart: &Chart) -> Self {
        let points = || chart.series.iter().flat_map(|s| s.points.iter());
        let bands = chart.series.iter().flat_map(|s| s.band.iter().flatten());
        let levels = points().map(|p| p.1).chain(bands.flat_map(|&(low, high)| [low, high]));
        let given = chart.y_range.filter(|(low, high)| low.is_finite() && high.is_finite() && low < high);
        let y = match given {
            Some(range) => Axis::exact(range, 5),
            None => Axis::covering(range(levels.chain(chart.references.iter().map(|r| r.y))), 5),
        };
        Self { x: Axis::snapped(range(points().map(|p| p.0)), 5), y }
    }

    /// A point of the chart in a box of the given size, y downwards.
    fn in_box(&self, (x, y): (f64, f64), (width, height): (f64, f64)) -> (f64, f64) {
        (self.x.fraction(x) * width, (1.0 - self.y.fraction(y)) * height)
    }
}

/// Whether the label of a level fits better on the right, where the curves are farther from it than on the left.
pub(super) fn label_on_right(chart: &Chart, axes: &Axes, level: f64) -> bool {
    let clearance = |inside: fn(f64) -> bool| {
        let points = chart.series.iter().flat_map(|s| &s.points).filter(|p| inside(axes.x.fraction(p.0)));
        points.map(|p| axes.y.fraction(p.1) - axes.y.fraction(level)).map(f64::abs).fold(f64::INFINITY, f64::min)
    };
    clearance(|x| x > 0.55) >= clearance(|x| x < 0.45)
}

/// The path of a curve; interrupted where a value is not finite.
pub(super) fn line(series: &Series, axes: &Axes, size: (f64, f64)) -> String {
    let mut path = String::new();
    let mut pen_down = false;
    for point in thinned(series).map(|i| series.points[i]) {
        if !(point.0.is_finite() && point.1.is_finite()) {
            pen_down = false;
            continue;
        }
        put(&mut path, if pen_down { 'L' } else { 'M' }, axes.in_box(point, size));
        pen_down = true;
    }
    path
}

/// The outline of a curve's band; empty when it has none.
pub(super) fn band(series: &Series, axes: &Axes, size: (f64, f64)) -> String {
    let Some(band) = series.band.as_ref().filter(|b| b.len() == series.points.len()) else {
        return String::new();
    };
    let finite = |&i: &usize| series.points[i].0.is_finite() && band[i].0.is_finite() && band[i].1.is_finite();
    let kept: Vec<usize> = thinned(series).filter(finite).collect();
    let mut path = String::new();
    for &i in &kept {
        let pen = if path.is_empty() { 'M' } else { 'L' };
        put(&mut path, pen, axes.in_box((series.points[i].0, band[i].1), size));
    }
    for &i in kept.iter().rev() {
        put(&mut path, 'L', axes.in_box((series.points[i].0, band[i].0), size));
    }
    if !path.is_empty() {
        path.push('Z');
    }
    path
}

/// Indices to draw: all, or of a long curve first, lowest, highest and last of each
/// stretch, so that no spike is lost.
fn thinned(series: &Series) -> impl Iterator<Item = usize> {
    let points = &series.points;
    let stretch = if points.len() <= MOST_POINTS { 1 } else { points.len().div_ceil(MOST_POINTS / 4) };
    (0..points.len()).step_by(stretch.max(1)).flat_map(move |start| {
        let end = (start + stretch).min(points.len());
        let by_y = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
        let mut kept = vec![start, end - 1];
        kept.extend((start..end).min_by(by_y));
        kept.extend((start..end).max_by(by_y));
        kept.sort_unstable();
        kept.dedup();
        kept
    })
}

fn put(path: &mut String, pen: char, (x, y): (f64, f64)) {
    // Rounding keeps the page small; a tenth of a unit is far below a pixel.
    let (x, y) = ((x * 10.0).round() / 10.0, (y * 10.0).round() / 10.0);
    let _ = write!(path, "{pen}{x} {y}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_is_thinned_but_keeps_its_spikes() {
        let mut points: Vec<_> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[77_777].1 = 9.0;
        let series = Series { name: "a".into(), points, band: None };
        let kept: Vec<_> = thinned(&series).collect();
        assert!(kept.len() <= MOST_POINTS && kept.contains(&77_777) && kept.contains(&99_999));
    }

    #[test]
    fn what_is_not_finite_interrupts_the_curve() {
        let points = vec![(0.0, 0.0), (1.0, f64::NAN), (2.0, 1.0), (4.0, 0.0)];
        let chart = Chart { series: vec![Series { name: "a".into(), points, band: None }], ..Chart::default() };
        assert_eq!(line(&chart.series[0], &Axes::of(&chart), (100.0, 10.0)), "M0 10M50 0L100 10");
    }
}
