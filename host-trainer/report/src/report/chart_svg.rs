//! A chart as a picture of its own, for documents.

use std::fmt::Write;

use super::chart::{Chart, Series};
use super::curve::{Axes, band, label_on_right, line};
use super::error::ReportError;
use super::escape::Escaped;
use super::palette::{Palette, classes};
use super::picture::STYLE;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 400.0;
/// The plot inside the picture: left, top, width, height.
const PLOT: (f64, f64, f64, f64) = (64.0, 76.0, 632.0, 272.0);

/// Where the first line of the legend is, and how far the next.
const FIRST_LINE: f64 = 50.0;
const NEXT_LINE: f64 = 20.0;

/// Positions of the series in the legend, which takes as many lines as it needs.
fn legend(chart: &Chart) -> Vec<(f64, f64)> {
    let (mut x, mut y) = (20.0, FIRST_LINE);
    let position = |series: &Series| {
        // Width of the text as such fonts go; a little room either way does no harm.
        let room = 48.0 + 7.0 * series.name.chars().count() as f64;
        if x > 20.0 && x + room > WIDTH {
            (x, y) = (20.0, y + NEXT_LINE);
        }
        let position = (x, y);
        x += room;
        position
    };
    chart.series.iter().map(position).collect()
}

/// The chart as an SVG file that follows the reader's light or dark setting.
///
/// # Errors
/// [`ReportError::Band`].
pub fn chart_svg(chart: &Chart) -> Result<String, ReportError> {
    chart.check()?;
    let axes = Axes::of(chart);
    let (left, top, width, height) = PLOT;
    let positions = legend(chart);
    let extra = positions.last().map_or(0.0, |last| last.1 - FIRST_LINE);
    let (top, all) = (top + extra, HEIGHT + extra);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {all}\" role=\"img\" aria-label=\"{title}\">\
         <style>{STYLE}</style><rect class=\"face\" width=\"{WIDTH}\" height=\"{all}\" rx=\"12\"/>\
         <text class=\"title\" x=\"20\" y=\"30\">{title}</text>",
        title = Escaped(&chart.title)
    );
    let mut palette = Palette::default();
    for (series, (x, y)) in chart.series.iter().zip(positions) {
        let class = classes(palette.index(&series.name));
        let name = Escaped(&series.name);
        let _ = write!(
            out,
            "<path class=\"line {class}\" d=\"M{x} {y}h18\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            x + 24.0,
            y + 4.0
        );
    }
    for tick in axes.y.ticks() {
        let y = top + (1.0 - axes.y.fraction(tick)) * height;
        let label = axes.y.label(tick);
        let _ = write!(out, "<path class=\"gridline\" d=\"M{left} {y:.1}h{width}\"/>");
        let _ = write!(out, "<text class=\"end\" x=\"{}\" y=\"{:.1}\">{label}</text>", left - 8.0, y + 4.0);
    }
    for tick in axes.x.ticks() {
        let (x, y) = (left + axes.x.fraction(tick) * width, top + height + 20.0);
        let _ = write!(out, "<text class=\"middle\" x=\"{x:.1}\" y=\"{y}\">{}</text>", axes.x.label(tick));
    }
    let right = left + width;
    let _ = write!(out, "<text class=\"end\" x=\"{right}\" y=\"{}\">{}</text>", all - 14.0, Escaped(&chart.x_label));
    let _ = write!(out, "<text class=\"end\" x=\"{right}\" y=\"30\">{}</text>", Escaped(&chart.y_label));
    for reference in chart.references.iter().filter(|r| (0.0..=1.0).contains(&axes.y.fraction(r.y))) {
        let y = top + (1.0 - axes.y.fraction(reference.y)) * height;
        let name = Escaped(&reference.name);
        let _ = write!(out, "<path class=\"reference\" d=\"M{left} {y:.1}h{width}\"/>");
        let (x, anchor) = if label_on_right(chart, &axes, reference.y) { (right, "end") } else { (left, "start") };
        let _ = write!(out, "<text class=\"{anchor}\" x=\"{x}\" y=\"{:.1}\">{name}</text>", y - 5.0);
    }
    let _ = write!(out, "<g transform=\"translate({left} {top})\">");
    for (kind, path) in [("band", band as fn(_, _, _) -> String), ("line", line)] {
        for series in &chart.series {
            let d = path(series, &axes, (width, height));
            if !d.is_empty() {
                let _ = write!(out, "<path class=\"{kind} {}\" d=\"{d}\"/>", classes(palette.index(&series.name)));
            }
        }
    }
    Ok(out + "</g></svg>\n")
}
