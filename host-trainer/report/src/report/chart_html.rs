//! A chart inside the page: an SVG that stretches, and HTML labels that do not, so
//! that text keeps its size from phone to desktop.

use std::fmt::Write;

use super::axis::range;
use super::chart::Chart;
use super::curve::{Axes, band, label_on_right, line};
use super::error::ReportError;
use super::escape::Escaped;
use super::number::number;
use super::palette::{Palette, classes};

/// Inner size of the plot; it is stretched to whatever room there is.
const SIZE: (f64, f64) = (1000.0, 1000.0);
/// A group of charts with one legend.
pub(super) fn charts(charts: &[Chart], palette: &mut Palette) -> Result<String, ReportError> {
    let mut legend = Vec::new();
    let mut figures = String::new();
    for c in charts {
        c.check()?;
        for series in &c.series {
            let index = palette.index(&series.name);
            if !legend.contains(&(index, series.name.as_str())) {
                legend.push((index, &series.name));
            }
        }
        figures += &figure(c, palette);
    }
    let mut out = String::from("<div class=\"charts\" data-charts>");
    if legend.len() > 1 {
        out += "<div class=\"legend\" role=\"group\" aria-label=\"Show or hide curves\">";
        for (index, name) in legend {
            let _ = write!(
                out,
                "<button type=\"button\" class=\"{}\" data-toggle=\"{index}\" aria-pressed=\"true\">\
                 <i></i>{}</button>",
                classes(index),
                Escaped(name)
            );
        }
        out += "</div>";
    }
    Ok(out + "<div class=\"grid\">" + &figures + "</div></div>")
}

fn figure(chart: &Chart, palette: &mut Palette) -> String {
    let axes = Axes::of(chart);
    let mut svg = String::from("<path class=\"gridline\" d=\"");
    let mut labels = String::new();
    for tick in axes.y.ticks() {
        let top = 1.0 - axes.y.fraction(tick);
        let _ = write!(svg, "M0 {:.1}H1000", top * 1000.0);
        let _ = write!(labels, "<span class=\"ty\" style=\"top:{:.2}%\">{}</span>", top * 100.0, axes.y.label(tick));
    }
    svg += "\"/>";
    for tick in axes.x.ticks() {
        let left = axes.x.fraction(tick) * 100.0;
        let _ = write!(labels, "<span class=\"tx\" style=\"left:{left:.2}%\">{}</span>", axes.x.label(tick));
    }
    for reference in chart.references.iter().filter(|r| (0.0..=1.0).contains(&axes.y.fraction(r.y))) {
        let top = 1.0 - axes.y.fraction(reference.y);
        let _ = write!(svg, "<path class=\"reference\" d=\"M0 {:.1}H1000\"/>", top * 1000.0);
        // Near the top there is no room above the line.
        let below = if top < 0.12 { " below" } else { "" };
        let left = if label_on_right(chart, &axes, reference.y) { "" } else { " left" };
        let _ = write!(
            labels,
            "<span class=\"reference{below}{left}\" style=\"top:{:.2}%\">{}</span>",
            top * 100.0,
            Escaped(&reference.name)
        );
    }
    for (kind, path) in [("band", band as fn(_, _, _) -> String), ("line", line)] {
        for series in &chart.series {
            let d = path(series, &axes, SIZE);
            let index = palette.index(&series.name);
            if !d.is_empty() {
                let name = Escaped(&series.name);
                let class = classes(index);
                let _ = write!(
                    svg,
                    "<path class=\"{kind} {class}\" data-series=\"{index}\" data-name=\"{name}\" d=\"{d}\"/>"
                );
            }
        }
    }
    if chart.series.iter().all(|s| s.points.is_empty()) {
        labels += "<span class=\"nothing\">no data yet</span>";
    }
    format!(
        "<figure class=\"chart\"><figcaption><h3>{title}</h3><span>{y}</span></figcaption>\
         <div class=\"plot\" data-plot=\"{x0} {x1} {y0} {y1}\" data-x=\"{x}\" tabindex=\"0\" role=\"img\" \
         aria-label=\"{summary}\"><svg viewBox=\"0 0 1000 1000\" preserveAspectRatio=\"none\" aria-hidden=\"true\">\
         {svg}</svg>{labels}</div><p class=\"x-label\">{x}</p></figure>",
        title = Escaped(&chart.title),
        x = Escaped(&chart.x_label),
        y = Escaped(&chart.y_label),
        x0 = axes.x.low(),
        x1 = axes.x.high(),
        y0 = axes.y.low(),
        y1 = axes.y.high(),
        summary = Escaped(&summary(chart)),
    )
}

/// The chart in words, for those who cannot see it.
fn summary(chart: &Chart) -> String {
    let mut out = format!("{} ({}) by {}.", chart.title, chart.y_label, chart.x_label);
    for series in &chart.series {
        let finite = || series.points.iter().map(|p| p.1).filter(|y| y.is_finite());
        if let (Some(first), Some(last)) = (finite().next(), finite().next_back()) {
            let (low, high) = range(finite());
            let [first, last, low, high] = [first, last, low, high].map(|v| number(v, 3));
            let _ = write!(out, " {}: from {first} to {last}, lowest {low}, highest {high}.", series.name);
        }
    }
    out
}
