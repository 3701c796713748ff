//! The fence's outline: from what was drawn to what the safety gate takes.

use super::plane::{Place, Scale};
use firmware_core::gate::{Geofence, GeofenceError, Vector};
use firmware_core::geometry::Vec2;

/// Corners of the gate's fence.
pub(super) const MOST_CORNERS: usize = 16;
/// A corner this near to the line between its neighbours is no corner, mm.
const FLAT_MM: f64 = 20.0;

/// A corner with its number in the file.
#[derive(Clone, Copy, Debug)]
struct Corner {
    index: usize,
    ticks: Vec2,
    at: [f64; 2],
}

/// An outline that the gate takes, and what became of the drawn one.
#[derive(Debug)]
pub(super) struct Shaped {
    pub corners: Vec<Vec2>,
    pub notes: Vec<String>,
}

/// Makes an outline of drawn corners: repeated ones are merged, and where there are too many those on a straight line
/// go. With `simplify` corners are cut off until the gate takes the rest; the area only shrinks.
pub(super) fn shape(drawn: &[Vec2], scale: Scale, simplify: bool) -> Result<Shaped, String> {
    let mut notes = Vec::new();
    let mut corners: Vec<Corner> = drawn
        .iter()
        .enumerate()
        .map(|(index, &ticks)| {
            let place: Place = scale.place(ticks);
            Corner { index, ticks, at: [place.east_mm, place.north_mm] }
        })
        .collect();
    if corners.len() > 1 && corners.first().map(|c| c.ticks) == corners.last().map(|c| c.ticks) {
        corners.pop();
    }
    let before = corners.len();
    corners.dedup_by_key(|c| millimetres(c));
    while corners.len() > 1 && corners.first().map(millimetres) == corners.last().map(millimetres) {
        corners.pop();
    }
    if corners.len() < before {
        notes.push(format!("{} repeating the one before: taken once", corners_in_words(before - corners.len())));
    }
    if corners.len() > MOST_CORNERS {
        let straight = straighten(&mut corners);
        if straight > 0 {
            notes.push(format!("{} on straight lines left out", corners_in_words(straight)));
        }
    }
    if corners.len() > MOST_CORNERS && simplify {
        let (count, area) = (corners.len(), area(&corners));
        cut_ears(&mut corners);
        let lost = 100.0 * (1.0 - self::area(&corners) / area.max(f64::MIN_POSITIVE));
        notes.push(format!(
            "simplified from {count} corners to {}, inside the drawn one: {lost:.1} % of the area is lost",
            corners.len()
        ));
    }
    if corners.len() > MOST_CORNERS {
        return Err(format!(
            "has {} corners, and the safety gate's fence has {MOST_CORNERS} at most. `sitl-bridge mission convert IN OUT \
             --simplify-fence` makes one of {MOST_CORNERS} that lies inside it; QGIS does by Vector, Geometry Tools, Simplify",
            corners.len()
        ));
    }
    let vectors: Vec<Vector> = corners.iter().map(vector).collect();
    match Geofence::polygon(&vectors) {
        Ok(_) => Ok(Shaped { corners: corners.iter().map(|c| c.ticks).collect(), notes }),
        Err(error) => Err(format!("cannot be used: {}", as_drawn(error, &corners))),
    }
}

fn corners_in_words(count: usize) -> String {
    if count == 1 { "1 corner".into() } else { format!("{count} corners") }
}

/// The gate's words with the numbers that the corners have in the file.
fn as_drawn(error: GeofenceError, corners: &[Corner]) -> String {
    let index = |i: usize| corners.get(i).map_or(i, |c| c.index);
    match error {
        GeofenceError::SamePoint(i) => GeofenceError::SamePoint(index(i)).to_string(),
        GeofenceError::Crossing(i, j) => {
            format!("{}; go around it in one direction", GeofenceError::Crossing(index(i), index(j)))
        }
        GeofenceError::TooSharp(i) => format!("{}, where no UAV can turn", GeofenceError::TooSharp(index(i))),
        GeofenceError::Corners(n) => format!("a fence has 3 to {MOST_CORNERS} corners, not {n}"),
        other => other.to_string(),
    }
}

fn vector(corner: &Corner) -> Vector {
    Vector::new(corner.at[0].round() as i32, corner.at[1].round() as i32)
}

fn millimetres(corner: &Corner) -> [i64; 2] {
    corner.at.map(|mm| mm.round() as i64)
}

/// Twice the signed area of a triangle, mm².
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Twice the signed area, mm²; positive when counter-clockwise.
fn signed_area(corners: &[Corner]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.at[0] * b.at[1] - a.at[1] * b.at[0]).sum()
}

fn area(corners: &[Corner]) -> f64 {
    signed_area(corners).abs()
}

fn neighbours(corners: &[Corner], i: usize) -> [[f64; 2]; 3] {
    let n = corners.len();
    [corners[(i + n - 1) % n].at, corners[i].at, corners[(i + 1) % n].at]
}

/// Takes corners on straight lines out, until there are few enough or no more of them.
fn straighten(corners: &mut Vec<Corner>) -> usize {
    let before = corners.len();
    let mut i = 0;
    while i < corners.len() && corners.len() > 3 {
        let [a, b, c] = neighbours(corners, i);
        let length = (c[0] - a[0]).hypot(c[1] - a[1]);
        let between = (b[0] - a[0]) * (c[0] - a[0]) + (b[1] - a[1]) * (c[1] - a[1]);
        if turn(a, b, c).abs() <= FLAT_MM * length && between >= 0.0 && between <= length * length {
            corners.remove(i);
        } else {
            i += 1;
        }
    }
    before - corners.len()
}

/// Cuts off the smallest corners that point outward, so that what is left lies inside.
fn cut_ears(corners: &mut Vec<Corner>) {
    while corners.len() > MOST_CORNERS {
        let sign = signed_area(corners).signum();
        let ear = |&i: &usize| {
            let [a, b, c] = neighbours(corners, i);
            let inside = |p: &Corner| {
                let sides = [turn(a, b, p.at), turn(b, c, p.at), turn(c, a, p.at)];
                sides.iter().all(|&side| side * sign >= 0.0)
            };
            let n = corners.len();
            let own = [(i + n - 1) % n, i, (i + 1) % n];
            turn(a, b, c) * sign > 0.0 && !corners.iter().enumerate().any(|(j, p)| !own.contains(&j) && inside(p))
        };
        let size = |i: usize| {
            let [a, b, c] = neighbours(corners, i);
            turn(a, b, c).abs()
        };
        let Some(least) = (0..corners.len()).filter(ear).min_by(|&i, &j| size(i).total_cmp(&size(j))) else { return };
        corners.remove(least);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SCALE: Scale = Scale { unit_m: 2.5, step_ms: 2000 };

    fn at(x: f64, y: f64) -> Vec2 {
        Vec2::from_u(x as f32, y as f32)
    }

    fn round(corners: usize, radius: impl Fn(usize) -> f64) -> Vec<Vec2> {
        let angle = |i: usize| i as f64 / corners as f64 * std::f64::consts::TAU;
        (0..corners).map(|i| at(100.0 + radius(i) * angle(i).cos(), 100.0 + radius(i) * angle(i).sin())).collect()
    }

    #[test]
    fn repeated_and_straight_corners_are_no_trouble() {
        let square = [at(0.0, 0.0), at(0.0, 0.0), at(100.0, 0.0), at(100.0, 100.0), at(0.0, 100.0), at(0.0, 0.0)];
        let shaped = shape(&square, SCALE, false).unwrap();
        assert_eq!((shaped.corners.len(), shaped.notes.len()), (4, 1));
        let side = |from: Vec2, to: Vec2| {
            (0..10).map(move |i| Vec2 { x: from.x + (to.x - from.x) * i / 10, y: from.y + (to.y - from.y) * i / 10 })
        };
        let [a, b, c, d] = [at(0.0, 0.0), at(90.0, 10.0), at(100.0, 100.0), at(-10.0, 80.0)];
        let many: Vec<_> = side(a, b).chain(side(b, c)).chain(side(c, d)).chain(side(d, a)).collect();
        let shaped = shape(&many, SCALE, false).unwrap();
        assert_eq!(shaped.corners.len(), 4, "{:?}", shaped.notes);
    }

    #[test]
    fn too_many_corners_say_what_to_do_and_can_be_made_fewer() {
        let circle = round(36, |_| 80.0);
        let said = shape(&circle, SCALE, false).unwrap_err();
        assert!(said.contains("has 36 corners") && said.contains("--simplify-fence"), "{said}");
        let shaped = shape(&circle, SCALE, true).unwrap();
        assert_eq!(shaped.corners.len(), 16);
        assert!(shaped.notes[0].contains("from 36 corners to 16"), "{:?}", shaped.notes);
    }

    proptest! {
        #[test]
        fn a_simplified_fence_lies_inside(
            radii in prop::collection::vec(40.0f64..90.0, 17..60), clockwise: bool,
        ) {
            let mut drawn = round(radii.len(), |i| radii[i]);
            if clockwise {
                drawn.reverse();
            }
            if let Ok(shaped) = shape(&drawn, SCALE, true) {
                prop_assert!(shaped.corners.len() <= MOST_CORNERS);
                // Seen from its middle, each corner is one of the drawn, and no edge passes outside a drawn corner
                // that it leaves out on the way: the middle of each edge lies inside.
                let inside = |p: [f64; 2]| {
                    let n = drawn.len();
                    let mut odd = false;
                    for i in 0..n {
                        let [a, b] = [drawn[i], drawn[(i + 1) % n]].map(|c| [f64::from(c.x), f64::from(c.y)]);
                        if (a[1] > p[1]) != (b[1] > p[1])
                            && p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0] {
                            odd = !odd;
                        }
                    }
                    odd
                };
                let n = shaped.corners.len();
                for i in 0..n {
                    let [a, b] = [shaped.corners[i], shaped.corners[(i + 1) % n]].map(|c| [f64::from(c.x), f64::from(c.y)]);
                    if drawn.contains(&shaped.corners[i]) {
                        for part in [0.25, 0.5, 0.75] {
                            // Half a metre inward: what lies on a straight line may be two centimetres off.
                            let p = [0, 1].map(|k| {
                                let on = a[k] + (b[k] - a[k]) * part;
                                on + (100.0 * 1024.0 - on) * 0.005
                            });
                            prop_assert!(inside(p), "edge {i}");
                        }
                    } else {
                        prop_assert!(false, "corner {i} is new");
                    }
                }
            }
        }
    }
}
