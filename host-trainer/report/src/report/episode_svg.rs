//! One step of an episode as a picture, for documents.

use std::fmt::Write;

use super::episode::Episode;
use super::error::ReportError;
use super::escape::Escaped;
use super::number::number;
use super::picture::STYLE;

/// Side of the map in the picture.
const SIDE: f32 = 600.0;
/// Free room around it.
const MARGIN: f32 = 20.0;
/// Room for the title and the key.
const HEAD: f32 = 56.0;
/// Steps of each trail.
const TRAIL: usize = 15;

/// The episode after `step` steps (0 is the spawn state) as an SVG file that follows
/// the reader's light or dark setting.
///
/// # Errors
/// [`ReportError::Step`] when there is no such step, or what contradicts itself in
/// the episode.
pub fn episode_svg(episode: &Episode, step: usize) -> Result<String, ReportError> {
    episode.check()?;
    let last = episode.steps();
    let frame =
        episode.frames.get(step).ok_or_else(|| ReportError::Step { episode: episode.title.clone(), step, last })?;
    let scale = SIDE / episode.side_u;
    let at = |p: [f32; 2]| (MARGIN + p[0] * scale, HEAD + SIDE - p[1] * scale);
    let there = |p: &[f32; 2]| p.iter().all(|c| c.is_finite());
    let (width, height) = (SIDE + 2.0 * MARGIN, SIDE + HEAD + MARGIN);
    let percent = number(f64::from(frame.coverage) * 100.0, 0);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"{title}: step {step} of {last}, {percent} % of the PoIs covered\"><style>{STYLE}</style>\
         <rect class=\"face\" width=\"{width}\" height=\"{height}\" rx=\"12\"/>\
         <text class=\"title\" x=\"{MARGIN}\" y=\"34\">{title}</text>\
         <text class=\"end\" x=\"{right}\" y=\"34\">step {step} of {last}, {percent} % covered</text>\
         <clipPath id=\"map\"><rect x=\"{MARGIN}\" y=\"{HEAD}\" width=\"{SIDE}\" height=\"{SIDE}\" rx=\"6\"/></clipPath>\
         <g clip-path=\"url(#map)\"><rect class=\"map\" x=\"{MARGIN}\" y=\"{HEAD}\" width=\"{SIDE}\" height=\"{SIDE}\"/>\
         <path class=\"gridline\" d=\"",
        title = Escaped(&episode.title),
        right = width - MARGIN,
    );
    for k in 1..4 {
        let line = SIDE * k as f32 / 4.0;
        let _ = write!(out, "M{} {HEAD}v{SIDE}M{MARGIN} {}h{SIDE}", MARGIN + line, HEAD + line);
    }
    out += "\"/>";
    // One path, so that discs that overlap are not darker.
    out += "<path class=\"disc\" d=\"";
    let radius = episode.coverage_range_u * scale;
    for uav in frame.uavs.iter().filter(|p| there(p)) {
        let (x, y) = at(*uav);
        let d = 2.0 * radius;
        let _ = write!(out, "M{:.1} {y:.1}a{radius} {radius} 0 1 0 {d} 0a{radius} {radius} 0 1 0 -{d} 0", x - radius);
    }
    out += "\"/>";
    trails(&mut out, episode, step, at);
    out += "<path class=\"edge\" d=\"";
    for [a, b] in &frame.edges {
        let [a, b] = [a, b].map(|&i| frame.uavs[usize::from(i)]);
        if there(&a) && there(&b) {
            let ((x1, y1), (x2, y2)) = (at(a), at(b));
            let _ = write!(out, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
        }
    }
    out += "\"/>";
    for (poi, covered) in episode.pois.iter().zip(&frame.covered) {
        let (class, r) = if *covered { ("covered", 3.2) } else { ("open", 2.7) };
        let (x, y) = at(*poi);
        let _ = write!(out, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\"/>");
    }
    for (i, uav) in frame.uavs.iter().enumerate().filter(|(_, p)| there(p)) {
        let (x, y) = at(*uav);
        let _ = match heading_degrees(episode, i, step) {
            Some(angle) => write!(
                out,
                "<path class=\"uav\" transform=\"translate({x:.1} {y:.1}) rotate({angle:.0})\" \
                 d=\"M8.5 0L-5.5 5.2L-3 0L-5.5 -5.2Z\"/>"
            ),
            None => write!(out, "<circle class=\"uav\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.6\"/>"),
        };
    }
    Ok(out + "</g></svg>\n")
}

/// The last steps of every UAV, older ones fainter.
fn trails(out: &mut String, episode: &Episode, step: usize, at: impl Fn([f32; 2]) -> (f32, f32)) {
    for from in step.saturating_sub(TRAIL)..step {
        let (a, b) = (&episode.frames[from].uavs, &episode.frames[from + 1].uavs);
        let opacity = 0.06 + 0.34 * (1.0 - (step - from) as f32 / (TRAIL + 1) as f32);
        let _ = write!(out, "<path class=\"trail\" opacity=\"{opacity:.2}\" d=\"");
        for (p, q) in a.iter().zip(b).filter(|(p, q)| p.iter().chain(*q).all(|c| c.is_finite())) {
            let ((x1, y1), (x2, y2)) = (at(*p), at(*q));
            let _ = write!(out, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
        }
        *out += "\"/>";
    }
}

/// Direction of the flight that leads to this step, degrees clockwise from east as
/// SVG turns; none when the UAV stands.
fn heading_degrees(episode: &Episode, uav: usize, step: usize) -> Option<f32> {
    let from = episode.frames.get(step.checked_sub(1)?)?.uavs.get(uav)?;
    let to = episode.frames.get(step)?.uavs.get(uav)?;
    let (east, north) = (to[0] - from[0], to[1] - from[1]);
    (east.hypot(north) >= 0.05).then(|| (-north).atan2(east).to_degrees())
}
