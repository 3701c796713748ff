//! Places for a disc that are worth a look, by the PoIs they cover.

/// A set of items in ascending order.
pub(crate) type Set = Vec<u32>;

/// Slack of the geometry in f64, u: two PoIs on a disc's edge count as on it.
const EDGE: f64 = 1e-9;

/// Centre and radius.
type Disc = ((f64, f64), f64);

/// Every maximal set of points that one disc of radius `r` covers. A disc that covers
/// several points can be moved, without losing one, until two of them lie on its edge;
/// so the discs through two points, and those around one point, are all there are.
pub(crate) fn maximal_sets(points: &[(f64, f64)], r: f64) -> Vec<Set> {
    let mut sets = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        sets.push(covered_from(points, a, r));
        for &b in &points[i + 1..] {
            for centre in edge_centres(a, b, r).into_iter().flatten() {
                sets.push(covered_from(points, centre, r));
            }
        }
    }
    keep_maximal(&mut sets);
    sets
}

fn covered_from(points: &[(f64, f64)], (x, y): (f64, f64), r: f64) -> Set {
    let limit = (r + EDGE) * (r + EDGE);
    let near = |&(px, py): &(f64, f64)| (px - x) * (px - x) + (py - y) * (py - y) <= limit;
    points.iter().enumerate().filter(|(_, p)| near(p)).map(|(i, _)| i as u32).collect()
}

/// Centres of the two discs of radius `r` with `a` and `b` on the edge, if there are.
fn edge_centres(a: (f64, f64), b: (f64, f64), r: f64) -> Option<[(f64, f64); 2]> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let d2 = dx * dx + dy * dy;
    if d2 == 0.0 || d2 > 4.0 * r * r {
        return None;
    }
    // From the middle, across: √(r² − d²/4) / d.
    let k = ((r * r - d2 / 4.0) / d2).max(0.0).sqrt();
    let (mx, my) = (a.0 + dx / 2.0, a.1 + dy / 2.0);
    Some([(mx - k * dy, my + k * dx), (mx + k * dy, my - k * dx)])
}

/// Drops every set contained in another; of equal sets one stays. The rest are ordered
/// by falling size, then by their items.
pub(crate) fn keep_maximal(sets: &mut Vec<Set>) {
    sets.sort_unstable_by(|a, b| b.len().cmp(&a.len()).then_with(|| a.cmp(b)));
    sets.dedup();
    let mut kept: Vec<Set> = Vec::with_capacity(sets.len());
    for set in sets.drain(..) {
        if !kept.iter().any(|k| is_subset(&set, k)) {
            kept.push(set);
        }
    }
    *sets = kept;
}

fn is_subset(a: &[u32], b: &[u32]) -> bool {
    let mut b = b.iter();
    a.iter().all(|x| b.by_ref().find(|&y| y >= x) == Some(x))
}

/// Centre and radius of the smallest disc around the points, by the incremental
/// algorithm: a point outside the disc so far lies on the edge of the next. (0, 0) and 0
/// without points.
pub(crate) fn smallest_disc(points: &[(f64, f64)]) -> Disc {
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

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (a.0 - b.0, a.1 - b.1);
    (dx * dx + dy * dy).sqrt()
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
