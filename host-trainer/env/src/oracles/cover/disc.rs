//! Discs through points and around points.

use crate::plane::{distance, squared_distance};

/// Tolerance of the geometry in f64, u: a point this little outside a disc counts as on its edge.
pub(super) const EDGE: f64 = 1e-9;

/// Centre and radius.
type Disc = ((f64, f64), f64);

/// Centres of the two discs of radius `r` with `a` and `b` on their edge; `None` for equal points and for points more
/// than 2`r` apart.
pub(super) fn discs_through(a: (f64, f64), b: (f64, f64), r: f64) -> Option<[(f64, f64); 2]> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let d2 = squared_distance(a, b);
    if d2 == 0.0 || d2 > 4.0 * r * r {
        return None;
    }
    // From the middle, across: √(r² − d²/4) / d.
    let k = ((r * r - d2 / 4.0) / d2).max(0.0).sqrt();
    let (mx, my) = (a.0 + dx / 2.0, a.1 + dy / 2.0);
    Some([(mx - k * dy, my + k * dx), (mx + k * dy, my - k * dx)])
}

/// Centre and radius of the smallest disc around the points, by the incremental algorithm (Welzl, without shuffling):
/// a point outside the disc so far lies on the edge of the next. (0, 0) and 0
/// without points.
pub(super) fn smallest_enclosing_disc(points: &[(f64, f64)]) -> Disc {
    let mut disc = ((0.0, 0.0), 0.0);
    let inside = |(centre, r): Disc, p| distance(p, centre) <= r + EDGE;
    for (i, &p) in points.iter().enumerate() {
        if i > 0 && inside(disc, p) {
            continue;
        }
        disc = (p, 0.0);
        for (j, &q) in points[..i].iter().enumerate() {
            if inside(disc, q) {
                continue;
            }
            disc = through_two(p, q);
            for &s in &points[..j] {
                if !inside(disc, s) {
                    disc = through_three(p, q, s);
                }
            }
        }
    }
    // In exact numbers the centre lies among the points; rounding must not move it out.
    let ((x, y), r) = disc;
    let among = |v: f64, axis: fn(&(f64, f64)) -> f64| {
        let low = points.iter().map(axis).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(axis).fold(f64::NEG_INFINITY, f64::max);
        if points.is_empty() { v } else { v.clamp(low, high) }
    };
    ((among(x, |p| p.0), among(y, |p| p.1)), r)
}

fn through_two(a: (f64, f64), b: (f64, f64)) -> Disc {
    let c = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
    (c, distance(a, c))
}

/// Circumcircle; of three points in a line, the disc over the two farthest apart.
fn through_three(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Disc {
    let (bx, by, cx, cy) = (b.0 - a.0, b.1 - a.1, c.0 - a.0, c.1 - a.1);
    let d = 2.0 * (bx * cy - by * cx);
    if d.abs() < 1e-12 {
        let larger = |m: Disc, d: Disc| if d.1 > m.1 { d } else { m };
        return larger(larger(through_two(a, b), through_two(a, c)), through_two(b, c));
    }
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let (ux, uy) = ((cy * b2 - by * c2) / d, (bx * c2 - cx * b2) / d);
    let c = (a.0 + ux, a.1 + uy);
    (c, distance(a, c))
}
