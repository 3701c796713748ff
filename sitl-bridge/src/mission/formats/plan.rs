//! QGroundControl's plans: waypoints are PoIs, the fence's inclusion is the fence.

use super::json::{named, values};
use super::ring;
use crate::mission::drawing::{Drawing, Order, Spot};
use crate::mission::fault::{Fault, broken, fault};
use serde_json::Value;

/// MAV_CMD_NAV_WAYPOINT and MAV_CMD_NAV_SPLINE_WAYPOINT.
pub(super) const WAYPOINTS: [u64; 2] = [16, 82];

/// Reads a plan.
pub(in crate::mission) fn read(text: &str) -> Result<Drawing, Fault> {
    let records = values(text)?;
    let [record] = &records[..] else { return Err(broken("a plan is one JSON object")) };
    let plan = &record.value;
    if plan.get("fileType").and_then(Value::as_str) != Some("Plan") {
        let kind = plan.get("fileType").map_or_else(|| "missing".into(), named);
        return Err(broken(format!(
            "its fileType is {kind}; a plan's is \"Plan\" (File, Save in QGroundControl's Plan view)"
        )));
    }
    let mut drawing = Drawing::new(Order::LatLon);
    drawing.home_alt_m = plan.pointer("/mission/plannedHomePosition/2").and_then(Value::as_f64);
    items(&mut drawing, plan)?;
    polygons(&mut drawing, plan)?;
    circles(&mut drawing, plan)?;
    if let Some(points) = plan.pointer("/rallyPoints/points").and_then(Value::as_array).filter(|p| !p.is_empty()) {
        drawing.notes.push(format!("{} rally points are not used: return is the autopilot's own", points.len()));
    }
    Ok(drawing)
}

fn items(drawing: &mut Drawing, plan: &Value) -> Result<(), Fault> {
    let Some(items) = plan.pointer("/mission/items").and_then(Value::as_array) else { return Ok(()) };
    let (mut taken, mut others) = (0, Vec::new());
    for (i, item) in items.iter().enumerate() {
        let at = format!("mission.items[{i}]");
        if item.get("type").and_then(Value::as_str) == Some("ComplexItem") {
            let kind = item.get("complexItemType").and_then(Value::as_str).unwrap_or("pattern");
            drawing
                .notes
                .push(format!("{at} is a {kind} and not used: PoIs are points, and the swarm finds its own way"));
            continue;
        }
        let Some(command) = item.get("command").and_then(Value::as_u64) else {
            return Err(fault(&at, "has no `command`"));
        };
        if !WAYPOINTS.contains(&command) {
            others.push(command);
            continue;
        }
        let number = |k: usize| item.pointer(&format!("/params/{k}")).and_then(Value::as_f64);
        match (number(4), number(5)) {
            (Some(lat), Some(lon)) if lat != 0.0 || lon != 0.0 => {
                drawing.poi(&at, lat, lon, None)?;
                taken += 1;
            }
            _ => drawing.notes.push(format!("{at} is a waypoint without a place and passed over")),
        }
    }
    say(drawing, taken, &others);
    Ok(())
}

/// What became of the items of a mission.
pub(super) fn say(drawing: &mut Drawing, taken: usize, others: &[u64]) {
    if taken > 0 {
        drawing.notes.push(format!(
            "{taken} waypoints are taken as PoIs; their order and altitudes are not used: the swarm finds its own way"
        ));
    }
    if !others.is_empty() {
        let mut kinds = others.to_vec();
        kinds.sort_unstable();
        kinds.dedup();
        let kinds: Vec<_> = kinds.iter().map(u64::to_string).collect();
        drawing.notes.push(format!(
            "{} other items are not used (MAV_CMD {}): takeoff, landing and the rest are the node's",
            others.len(),
            kinds.join(", ")
        ));
    }
}

fn is_inclusion(shape: &Value) -> bool {
    shape.get("inclusion").and_then(Value::as_bool).unwrap_or(true)
}

fn polygons(drawing: &mut Drawing, plan: &Value) -> Result<(), Fault> {
    // Its first form had one polygon, a bare array.
    let bare = plan.pointer("/geoFence/polygon").and_then(Value::as_array).filter(|p| !p.is_empty());
    if let Some(corners) = bare {
        let corners = corners_of(drawing, corners, "geoFence.polygon")?;
        drawing.set_fence("geoFence.polygon", corners)?;
    }
    let Some(polygons) = plan.pointer("/geoFence/polygons").and_then(Value::as_array) else { return Ok(()) };
    for (i, polygon) in polygons.iter().enumerate() {
        let at = format!("geoFence.polygons[{i}]");
        if !is_inclusion(polygon) {
            return Err(keep_out(&at));
        }
        let corners = polygon.get("polygon").and_then(Value::as_array).filter(|p| !p.is_empty());
        let corners = corners.ok_or_else(|| fault(&at, "is a polygon without corners: draw them, or remove it"))?;
        let corners = corners_of(drawing, corners, &at)?;
        drawing.set_fence(&at, corners)?;
    }
    Ok(())
}

pub(super) fn keep_out(at: &str) -> Fault {
    fault(
        at,
        "is an exclusion, and a mission knows no area inside its fence to keep out of: draw the fence around it, or remove it",
    )
}

fn corners_of(drawing: &mut Drawing, corners: &[Value], at: &str) -> Result<Vec<Spot>, Fault> {
    let mut spots = Vec::with_capacity(corners.len());
    for (i, corner) in corners.iter().enumerate() {
        let at = format!("{at} corner {i}");
        let (lat, lon) = pair(Some(corner), &at)?;
        spots.push(drawing.spot(&at, lat, lon, None)?);
    }
    Ok(spots)
}

fn circles(drawing: &mut Drawing, plan: &Value) -> Result<(), Fault> {
    let Some(circles) = plan.pointer("/geoFence/circles").and_then(Value::as_array) else { return Ok(()) };
    for (i, shape) in circles.iter().enumerate() {
        let at = format!("geoFence.circles[{i}]");
        if !is_inclusion(shape) {
            return Err(keep_out(&at));
        }
        let circle = shape.get("circle").unwrap_or(shape);
        let centre = pair(circle.get("center"), &format!("{at}.circle.center"))?;
        let radius_m = circle.get("radius").and_then(Value::as_f64).unwrap_or_default();
        ring::draw(drawing, &at, centre, radius_m)?;
    }
    Ok(())
}

fn pair(value: Option<&Value>, at: &str) -> Result<(f64, f64), Fault> {
    let pair = value.and_then(|v| Some((v.get(0)?.as_f64()?, v.get(1)?.as_f64()?)));
    pair.ok_or_else(|| fault(at, "is no position: [latitude, longitude]"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn plan(polygons: &Value, circles: &Value) -> String {
        json!({
            "fileType": "Plan", "version": 1, "groundStation": "QGroundControl",
            "geoFence": {"circles": circles, "polygons": polygons, "version": 2},
            "rallyPoints": {"points": [[47.4, 8.5, 50]], "version": 2},
            "mission": {
                "plannedHomePosition": [47.4, 8.5, 412.5],
                "items": [
                    {"type": "SimpleItem", "command": 22, "params": [0, 0, 0, null, 47.4, 8.5, 20]},
                    {"type": "SimpleItem", "command": 16, "params": [0, 0, 0, null, 47.401, 8.501, 20]},
                    {"type": "SimpleItem", "command": 82, "params": [0, 0, 0, null, 47.402, 8.502, 20]},
                    {"type": "SimpleItem", "command": 16, "params": [0, 0, 0, null, 0, 0, 20]},
                    {"type": "ComplexItem", "complexItemType": "survey"},
                    {"type": "SimpleItem", "command": 20, "params": [0, 0, 0, 0, 0, 0, 0]},
                ],
            },
        })
        .to_string()
    }

    #[test]
    fn waypoints_are_pois_and_the_inclusion_is_the_fence() {
        let inside = json!([{"inclusion": true, "polygon": [[47.4, 8.5], [47.4, 8.51], [47.41, 8.51]]}]);
        let drawing = read(&plan(&inside, &json!([]))).unwrap();
        let at: Vec<_> = drawing.pois.iter().map(|p| (p.at.as_str(), p.lat)).collect();
        assert_eq!(at, [("mission.items[1]", 47.401), ("mission.items[2]", 47.402)]);
        assert_eq!((drawing.fence.as_ref().unwrap().corners.len(), drawing.home_alt_m), (3, Some(412.5)));
        let notes = drawing.notes.join("\n");
        for words in
            ["2 waypoints are taken", "MAV_CMD 20, 22", "items[3] is a waypoint without a place", "survey", "1 rally"]
        {
            assert!(notes.contains(words), "{words}: {notes}");
        }
    }

    #[test]
    fn circles_are_drawn_and_exclusions_refused() {
        let circle =
            |inclusion: bool| json!([{"inclusion": inclusion, "circle": {"center": [47.4, 8.5], "radius": 100.0}}]);
        let drawing = read(&plan(&json!([]), &circle(true))).unwrap();
        assert_eq!(drawing.fence.unwrap().corners.len(), 16);
        assert!(read(&plan(&json!([]), &circle(false))).unwrap_err().problem.contains("is an exclusion"));
        let both = json!([{"inclusion": true, "polygon": [[47.4, 8.5], [47.4, 8.51], [47.41, 8.51]]}]);
        assert!(read(&plan(&both, &circle(true))).unwrap_err().problem.contains("second polygon"));
        assert!(read(&plan(&json!([{"inclusion": false, "polygon": []}]), &json!([]))).is_err());
        assert!(read("{\"fileType\": \"Parameters\"}").unwrap_err().problem.contains("\"Parameters\""));
    }
}
