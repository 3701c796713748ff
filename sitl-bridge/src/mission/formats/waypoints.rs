//! Waypoint lists, `QGC WPL 110`: Mission Planner's, MAVProxy's and QGroundControl's, those of fences among them.

use super::plan::{WAYPOINTS, keep_out, say};
use super::ring;
use crate::mission::drawing::{Drawing, Order, Spot};
use crate::mission::fault::{Fault, broken, fault};

/// MAV_CMD_NAV_FENCE_* and MAV_CMD_NAV_RALLY_POINT.
const INCLUDED_CORNER: u64 = 5001;
const EXCLUDED_CORNER: u64 = 5002;
const INCLUDED_CIRCLE: u64 = 5003;
const EXCLUDED_CIRCLE: u64 = 5004;
const RALLY: u64 = 5100;
/// Columns of a line.
const COLUMNS: usize = 12;

/// Reads a list.
pub(in crate::mission) fn read(text: &str) -> Result<Drawing, Fault> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let head = lines.next().map_or("", |(_, line)| line.trim());
    match head.strip_prefix("QGC WPL").map(str::trim) {
        Some("110") => {}
        Some(version) => {
            return Err(broken(format!(
                "it is version `{version}` of the list; save it as 110, which all planners write"
            )));
        }
        None => return Err(broken("a waypoint list begins with `QGC WPL 110`")),
    }
    let mut drawing = Drawing::new(Order::LatLon);
    let (mut taken, mut others, mut corners, mut rally) = (0, Vec::new(), Vec::<Spot>::new(), 0);
    for (index, line) in lines.filter(|(_, line)| !line.trim_start().starts_with('#')) {
        let at = format!("line {}", index + 1);
        let item = Item::read(line, &at)?;
        if item.sequence == 0.0 && WAYPOINTS.contains(&item.command) {
            drawing.home_alt_m = Some(item.alt_m).filter(|alt| alt.is_finite() && *alt != 0.0);
            drawing.notes.push(format!("{at}, number 0, is the home position and no PoI"));
            continue;
        }
        let has_place = item.lat != 0.0 || item.lon != 0.0;
        match item.command {
            command if WAYPOINTS.contains(&command) && has_place => {
                drawing.poi(&at, item.lat, item.lon, None)?;
                taken += 1;
            }
            command if WAYPOINTS.contains(&command) => {
                drawing.notes.push(format!("{at} is a waypoint without a place and passed over"));
            }
            INCLUDED_CORNER => {
                let more_than_one = corners.len() as f64 >= item.first && item.first >= 3.0;
                if more_than_one {
                    return Err(fault(&at, "begins a second fence; a mission has one"));
                }
                corners.push(drawing.spot(&at, item.lat, item.lon, None)?);
            }
            INCLUDED_CIRCLE => ring::draw(&mut drawing, &at, (item.lat, item.lon), item.first)?,
            EXCLUDED_CORNER | EXCLUDED_CIRCLE => return Err(keep_out(&at)),
            RALLY => rally += 1,
            other => others.push(other),
        }
    }
    if let Some(first) = corners.first() {
        let at = format!("the fence from {} on", first.at);
        drawing.set_fence(&at, corners)?;
    }
    say(&mut drawing, taken, &others);
    if rally > 0 {
        drawing.notes.push(format!("{rally} rally points are not used: return is the autopilot's own"));
    }
    Ok(drawing)
}

/// One line.
struct Item {
    sequence: f64,
    command: u64,
    /// The first parameter: a circle's radius, m, or a polygon's number of corners.
    first: f64,
    lat: f64,
    lon: f64,
    alt_m: f64,
}

impl Item {
    fn read(line: &str, at: &str) -> Result<Self, Fault> {
        let fields: Vec<_> = line.split_whitespace().collect();
        if fields.len() != COLUMNS {
            return Err(fault(
                at,
                format!("has {} columns; a waypoint has {COLUMNS}, with tabs between", fields.len()),
            ));
        }
        let number = |i: usize| {
            fields[i].parse::<f64>().map_err(|_| {
                let comma = if fields[i].contains(',') { ": numbers have a decimal point" } else { "" };
                fault(at, format!("has `{}` in column {}, which is no number{comma}", fields[i], i + 1))
            })
        };
        let command = number(3)?;
        if !(0.0..=65_535.0).contains(&command) {
            return Err(fault(at, format!("has the command {command}; commands go from 0 to 65535")));
        }
        Ok(Self {
            sequence: number(0)?,
            command: command as u64,
            first: number(4)?,
            lat: number(8)?,
            lon: number(9)?,
            alt_m: number(10)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waypoints_and_fences_are_read_and_the_rest_is_named() {
        let list = "QGC WPL 110\r\n0\t1\t0\t16\t0\t0\t0\t0\t47.4\t8.5\t412.5\t1\r\n1\t0\t3\t22\t0\t0\t0\t0\t0\t0\t20\t1\r\n\
            2\t0\t3\t16\t0\t0\t0\t0\t47.401\t8.501\t20\t1\r\n3 0 3 16 0 0 0 0 47.402 8.502 20 1\r\n";
        let drawing = read(list).unwrap();
        assert_eq!(drawing.pois.iter().map(|p| p.lat).collect::<Vec<_>>(), [47.401, 47.402]);
        assert_eq!((drawing.home_alt_m, drawing.pois[0].at.as_str()), (Some(412.5), "line 4"));
        assert!(drawing.notes.join("\n").contains("MAV_CMD 22"), "{:?}", drawing.notes);
        let corner = |n: u32, lat: f64, lon: f64| format!("{n} 0 0 5001 3 0 0 0 {lat} {lon} 0 1\n");
        let fence =
            ["QGC WPL 110\n".into(), corner(1, 47.4, 8.5), corner(2, 47.4, 8.51), corner(3, 47.41, 8.5)].concat();
        assert_eq!(read(&fence).unwrap().fence.unwrap().corners.len(), 3);
        for (more, words) in [
            (corner(4, 47.4, 8.5), "line 5 begins a second fence"),
            ("4 0 0 5002 3 0 0 0 47.4 8.5 0 1".into(), "line 5 is an exclusion"),
            ("4 0 3 16 0 0 0 0 47,4 8,5 0 1".into(), "numbers have a decimal point"),
            ("4 0 3 16 0 0 0 0 8.5".into(), "has 9 columns"),
            ("4 0 3 16 0 0 0 0 108.5 47.4 0 1".into(), "swapped"),
        ] {
            let said = read(&format!("{fence}{more}")).unwrap_err().problem;
            assert!(said.contains(words), "{said}");
        }
        assert!(read("QGC WPL 120\n").unwrap_err().problem.contains("version `120`"));
    }
}
