//! Places of Google Earth and its kin: points of placemarks are PoIs, a polygon is the fence.

use crate::mission::drawing::{Drawing, Order, Spot};
use crate::mission::fault::{Fault, broken, fault};
use crate::mission::text::Lines;
use roxmltree::{Document, Node};

/// Shapes that hold no place of their own.
const OVERLAYS: [&str; 5] = ["GroundOverlay", "ScreenOverlay", "PhotoOverlay", "Model", "Track"];

/// Reads a document.
pub(in crate::mission) fn read(text: &str) -> Result<Drawing, Fault> {
    let document = Document::parse(text).map_err(|e| broken(format!("broken XML: {e}")))?;
    let lines = Lines::of(text);
    let root = document.root_element();
    if root.tag_name().name() != "kml" {
        return Err(broken(format!("its root is `{}`; KML's is `kml`", root.tag_name().name())));
    }
    let mut drawing = Drawing::new(Order::LonLat);
    for node in root.descendants().filter(Node::is_element) {
        let name = node.tag_name().name();
        let at = || place(node, &lines);
        match name {
            "Point" => {
                let at = at();
                let numbers = positions(node, &at)?;
                match numbers.as_slice() {
                    [] => drawing.notes.push(format!("{at} is a point without coordinates and passed over")),
                    [one] => drawing.poi(&at, one.lat, one.lon, altitude(node, one))?,
                    several => {
                        return Err(fault(&at, format!("is a Point with {} positions; it has one", several.len())));
                    }
                }
            }
            "Polygon" => polygon(&mut drawing, node, &at())?,
            "LineString" | "LinearRing" if !has_ancestor(node, "Polygon") => {
                let at = at();
                let numbers = positions(node, &at)?;
                let ends = numbers.len() >= 4 && numbers.first() == numbers.last();
                drawing.line(&at, name, Some(ends || name == "LinearRing"))?;
            }
            "NetworkLink" => {
                drawing
                    .notes
                    .push(format!("{} is a link to another file and not followed: export the places themselves", at()));
            }
            _ if OVERLAYS.contains(&name) => drawing.notes.push(format!("{} is a {name} and not used", at())),
            _ => {}
        }
    }
    Ok(drawing)
}

/// A position as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Written {
    lat: f64,
    lon: f64,
    alt_m: Option<f64>,
}

fn polygon(drawing: &mut Drawing, node: Node<'_, '_>, at: &str) -> Result<(), Fault> {
    let boundary = |name: &'static str| node.children().filter(move |c| c.tag_name().name() == name);
    let mut holes = 0;
    for inner in boundary("innerBoundaryIs") {
        holes += usize::from(!positions(inner, at)?.is_empty());
    }
    if holes > 0 {
        return Err(fault(at, "is a polygon with a hole, and a fence has none: remove the inner boundary"));
    }
    let outer = boundary("outerBoundaryIs").next().map(|outer| positions(outer, at)).transpose()?.unwrap_or_default();
    if outer.is_empty() {
        return Err(fault(at, "is a Polygon without corners: draw them, or remove it"));
    }
    let mut corners: Vec<Spot> = Vec::with_capacity(outer.len());
    for (i, corner) in outer.iter().enumerate() {
        corners.push(drawing.spot(&format!("{at} corner {i}"), corner.lat, corner.lon, None)?);
    }
    drawing.set_fence(at, corners)
}

/// The altitude counts from the sea only where the shape says so.
fn altitude(node: Node<'_, '_>, written: &Written) -> Option<f64> {
    let absolute =
        node.children().any(|c| c.tag_name().name() == "altitudeMode" && c.text().map(str::trim) == Some("absolute"));
    written.alt_m.filter(|_| absolute)
}

/// `longitude,latitude[,altitude]`, with white space between positions.
fn positions(node: Node<'_, '_>, at: &str) -> Result<Vec<Written>, Fault> {
    let Some(element) = node.descendants().find(|n| n.tag_name().name() == "coordinates") else {
        return Ok(Vec::new());
    };
    let text: String = element.children().filter_map(|child| child.text()).collect();
    let mut positions = Vec::new();
    for tuple in text.split_whitespace() {
        let form = || {
            fault(
                at,
                format!(
                    "has the position `{}`; KML writes longitude,latitude,altitude without spaces and with decimal points",
                    tuple.chars().take(40).collect::<String>()
                ),
            )
        };
        let numbers: Vec<f64> = tuple.split(',').map(|n| n.parse().map_err(|_| form())).collect::<Result<_, _>>()?;
        match numbers[..] {
            [lon, lat] => positions.push(Written { lat, lon, alt_m: None }),
            [lon, lat, alt] => positions.push(Written { lat, lon, alt_m: Some(alt).filter(|a| a.is_finite()) }),
            _ => return Err(form()),
        }
    }
    Ok(positions)
}

fn has_ancestor(node: Node<'_, '_>, name: &str) -> bool {
    node.ancestors().skip(1).any(|a| a.tag_name().name() == name)
}

/// The placemark's name and line.
fn place(node: Node<'_, '_>, lines: &Lines) -> String {
    let placemark = node.ancestors().find(|a| a.tag_name().name() == "Placemark").unwrap_or(node);
    let line = lines.line(placemark.range().start);
    let named = placemark.children().find(|c| c.tag_name().name() == "name").and_then(|name| name.text());
    match named.map(str::trim).filter(|name| !name.is_empty()) {
        Some(name) => format!("`{}` (line {line})", name.chars().take(40).collect::<String>()),
        None => format!("the {} in line {line}", placemark.tag_name().name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(placemarks: &str) -> Result<Drawing, String> {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document>\n{placemarks}\n</Document></kml>"
        );
        super::read(&text).map_err(|f| f.problem)
    }

    #[test]
    fn points_and_the_polygon_of_placemarks_in_folders() {
        let drawing = read(
            "<Folder><Placemark><name>Barn</name><Point><coordinates> 8.501,47.401,430 </coordinates></Point></Placemark>
            <Placemark><MultiGeometry><Point><altitudeMode>absolute</altitudeMode><coordinates>8.502,47.402,430</coordinates></Point>
            <LineString><coordinates>8.5,47.4 8.6,47.5</coordinates></LineString></MultiGeometry></Placemark></Folder>
            <Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>8.5,47.4,0 8.51,47.4,0\n8.51,47.41,0 8.5,47.4,0
            </coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>",
        )
        .unwrap();
        let [barn, other] = &drawing.pois[..] else { panic!("{drawing:?}") };
        assert_eq!((barn.at.as_str(), barn.lat, barn.alt_m), ("`Barn` (line 3)", 47.401, None));
        assert_eq!((other.lon, other.alt_m), (8.502, Some(430.0)));
        assert_eq!(drawing.fence.unwrap().corners.len(), 4);
        assert!(drawing.notes[0].contains("line 4 is a LineString and not used"), "{:?}", drawing.notes);
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let ring = "<LinearRing><coordinates>8.5,47.4 8.51,47.4 8.51,47.41 8.5,47.4</coordinates></LinearRing>";
        for (placemarks, words) in [
            (
                format!(
                    "<Placemark><Polygon><outerBoundaryIs>{ring}</outerBoundaryIs><innerBoundaryIs>{ring}</innerBoundaryIs></Polygon></Placemark>"
                ),
                "with a hole",
            ),
            ("<Placemark><Polygon/></Placemark>".into(), "without corners"),
            (format!("<Placemark>{ring}</Placemark>"), "draw it as a Polygon"),
            ("<Point><coordinates>8.5, 47.4</coordinates></Point>".into(), "`8.5,`; KML writes longitude,latitude"),
            ("<Point><coordinates>8,501,47,401</coordinates></Point>".into(), "decimal points"),
            ("<Point><coordinates>47.4,108.5</coordinates></Point>".into(), "swapped"),
            ("<Point>".into(), "broken XML"),
        ] {
            let said = read(&placemarks).unwrap_err();
            assert!(said.contains(words), "{placemarks}: {said}");
        }
        assert!(super::read("<a/>").unwrap_err().problem.contains("its root is `a`"));
    }
}
