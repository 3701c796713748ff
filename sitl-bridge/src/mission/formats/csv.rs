//! Tables of points: a header that names latitude and longitude, or two columns in that order.

use crate::mission::drawing::{Drawing, Order};
use crate::mission::fault::{Fault, broken, fault};

/// Names of columns, in lower case and without marks; the first that is there counts.
const LATITUDE: [&str; 9] =
    ["latitude", "lat", "latdeg", "latitudedeg", "decimallatitude", "gpslatitude", "latwgs84", "ycoord", "y"];
const LONGITUDE: [&str; 11] = [
    "longitude",
    "lon",
    "lng",
    "long",
    "londeg",
    "longitudedeg",
    "decimallongitude",
    "gpslongitude",
    "lonwgs84",
    "xcoord",
    "x",
];

/// One row.
struct Row {
    /// From 1.
    line: usize,
    fields: Vec<String>,
}

/// Whether a line is the beginning of a table of points: names of both columns, or two numbers.
pub(super) fn is_table(line: &str) -> bool {
    if line.to_ascii_lowercase().starts_with("sep=") {
        return true;
    }
    let Some(separator) = separator(line) else { return false };
    let fields: Vec<_> = line.split(separator).map(|f| f.trim().trim_matches('"')).collect();
    let is_number = |f: &&&str| f.parse::<f64>().is_ok_and(f64::is_finite) || has_comma(f);
    fields.iter().take(2).filter(is_number).count() == 2
        || (column(&fields, &LATITUDE).is_some() && column(&fields, &LONGITUDE).is_some())
}

/// Reads a table.
pub(in crate::mission) fn read(text: &str) -> Result<Drawing, Fault> {
    let mut text = text;
    let mut offset = 0;
    let mut separator_said = None;
    if text.get(..4).is_some_and(|head| head.eq_ignore_ascii_case("sep=")) {
        let (head, rest) = text.split_once('\n').unwrap_or((text, ""));
        separator_said = head[4..].chars().next().filter(|&c| c != '\r');
        (text, offset) = (rest, 1);
    }
    let is_row = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let first = text.lines().find(is_row).ok_or_else(|| broken("it has no row"))?;
    let separator = separator_said.or_else(|| separator(first)).ok_or_else(|| {
        broken(format!(
            "`{}` is one column; a table has a latitude and a longitude, with `,`, `;` or tabs between",
            first.trim().chars().take(40).collect::<String>()
        ))
    })?;
    let rows = rows(text, separator, offset);
    let mut rows = rows.iter();
    let mut peeked = rows.clone();
    let head = peeked.next().ok_or_else(|| broken("it has no row"))?;
    let names: Vec<_> = head.fields.iter().map(String::as_str).collect();
    let is_header = !names.iter().take(2).all(|f| looks_like_number(f));
    let (lat, lon, order, width) = if is_header {
        rows.next();
        let (lat, lon) = columns(&names)?;
        (lat, lon, if lat < lon { Order::LatLon } else { Order::LonLat }, names.len())
    } else {
        (0, 1, Order::LatLon, 2)
    };
    let mut drawing = Drawing::new(order);
    if !is_header {
        drawing.notes.push("it has no header: the first column is taken as latitude, the second as longitude".into());
    }
    let mut blank = 0;
    for row in rows {
        let at = format!("line {}", row.line);
        if row.fields.len() > width {
            refuse_wide(row, width, is_header, separator, &at)?;
        }
        let field = |i: usize| row.fields.get(i).map_or("", |f| f.trim());
        if field(lat).is_empty() && field(lon).is_empty() {
            blank += 1;
            continue;
        }
        let (lat, lon) = (degrees(field(lat), "latitude", &at)?, degrees(field(lon), "longitude", &at)?);
        drawing.poi(&at, lat, lon, None)?;
    }
    if blank > 0 {
        drawing.notes.push(format!("{blank} rows have no position and are passed over"));
    }
    Ok(drawing)
}

fn columns(names: &[&str]) -> Result<(usize, usize), Fault> {
    if names.iter().any(|n| ["wkt", "wktgeom", "geometry", "geom", "thegeom"].contains(&plain(n).as_str()))
        && column(names, &LATITUDE).is_none()
    {
        return Err(broken(
            "its points stand in a column of WKT; export with columns of their own (QGIS: Save Features As, GEOMETRY=AS_XY)",
        ));
    }
    match (column(names, &LATITUDE), column(names, &LONGITUDE)) {
        (Some(lat), Some(lon)) => Ok((lat, lon)),
        (lat, lon) => {
            let missing = match (lat, lon) {
                (None, None) => "neither a latitude nor a longitude",
                (None, _) => "no latitude",
                _ => "no longitude",
            };
            let shown: Vec<_> = names.iter().take(10).map(|n| format!("`{}`", n.trim())).collect();
            Err(broken(format!(
                "its header has {missing} ({}); name the columns lat and lon (or latitude, longitude, lng, y and x)",
                shown.join(", ")
            )))
        }
    }
}

/// A row with more fields than there are columns: commas of another kind, most likely.
fn refuse_wide(row: &Row, width: usize, is_header: bool, separator: char, at: &str) -> Result<(), Fault> {
    let whole =
        |f: &String| f.trim().trim_start_matches('-').bytes().all(|b| b.is_ascii_digit()) && !f.trim().is_empty();
    if separator == ',' && row.fields.len() == 2 * width && row.fields.iter().take(4).all(whole) {
        return Err(fault(
            at,
            format!(
                "has {} numbers: decimal commas? Write 47.401, with a point, or export with the point",
                row.fields.len()
            ),
        ));
    }
    if !is_header {
        return Err(fault(
            at,
            format!(
                "has {} columns; with more than two a header tells which they are, such as `lat,lon,name`",
                row.fields.len()
            ),
        ));
    }
    Ok(())
}

fn degrees(text: &str, what: &str, at: &str) -> Result<f64, Fault> {
    if text.is_empty() {
        return Err(fault(at, format!("has no {what}")));
    }
    if let Some(number) = text.parse::<f64>().ok().filter(|n| n.is_finite()) {
        return Ok(number);
    }
    let advice = if has_comma(text) {
        format!("a decimal comma: write {}, with a point, or export with the point", text.replace(',', "."))
    } else if text.parse::<f64>().is_ok() {
        "no number".to_owned()
    } else {
        "no decimal number of degrees: write 47.401, south and west with a minus".to_owned()
    };
    Err(fault(at, format!("has the {what} `{}`, and that is {advice}", text.chars().take(30).collect::<String>())))
}

fn has_comma(text: &str) -> bool {
    text.contains(',') && text.replacen(',', ".", 1).trim().parse::<f64>().is_ok_and(f64::is_finite)
}

fn looks_like_number(text: &str) -> bool {
    let text = text.trim();
    text.parse::<f64>().is_ok()
        || has_comma(text)
        || text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+')
}

/// A column's name without case, marks and units.
fn plain(name: &str) -> String {
    let name = name.split(['(', '[']).next().unwrap_or_default();
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn column(names: &[&str], known: &[&str]) -> Option<usize> {
    known.iter().find_map(|known| names.iter().position(|name| plain(name) == *known))
}

/// The separator of a line.
fn separator(line: &str) -> Option<char> {
    ['\t', ';', ','].into_iter().find(|&c| line.contains(c))
}

/// The rows of a table; fields in double quotes may hold anything.
fn rows(text: &str, separator: char, offset: usize) -> Vec<Row> {
    let mut rows = Vec::new();
    let (mut line, mut begins) = (offset + 1, offset + 1);
    let (mut fields, mut field, mut quoted) = (Vec::new(), String::new(), false);
    let mut chars = text.chars().chain(std::iter::once('\n')).peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => {
                chars.next();
                field.push('"');
            }
            '"' if quoted || field.trim().is_empty() => quoted = !quoted,
            c if c == separator && !quoted => fields.push(std::mem::take(&mut field)),
            '\n' if !quoted || chars.peek().is_none() => {
                fields.push(std::mem::take(&mut field));
                let row = std::mem::take(&mut fields);
                let is_comment = row.first().is_some_and(|f| f.trim_start().starts_with('#'));
                if !is_comment && row.iter().any(|f| !f.trim().is_empty()) {
                    rows.push(Row { line: begins, fields: row });
                }
                line += 1;
                begins = line;
            }
            '\r' if !quoted => {}
            c => {
                line += usize::from(c == '\n');
                field.push(c);
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(text: &str) -> Vec<(f64, f64)> {
        read(text).unwrap_or_else(|f| panic!("{text}: {}", f.problem)).pois.iter().map(|p| (p.lat, p.lon)).collect()
    }

    fn said(text: &str) -> String {
        read(text).unwrap_err().problem
    }

    #[test]
    fn columns_are_found_by_name_whatever_the_separator() {
        let expected = [(47.401, 8.501), (47.402, 8.502)];
        for text in [
            "lat,lon\n47.401,8.501\n47.402,8.502\n",
            "47.401,8.501\n47.402,8.502",
            "Name;Longitude;LATITUDE\r\n\"a;b\";8.501;47.401\r\nc;8.502;47.402\r\n",
            "lng\tlat\n8.501\t47.401\n\n# no\n8.502\t47.402",
            "X,Y,name\n8.501,47.401,\"say \"\"so\"\", or\nnot\"\n8.502,47.402,b",
            "sep=;\nlatitude (deg);Longitude [°]\n47.401;8.501\n47.402;8.502",
            "id,y,x,lat,lon\n1,0,0,47.401,8.501\n2,,,\"47.402\",8.502\n3,,,,\n",
        ] {
            assert_eq!(points(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, words) in [
            ("lat;lon\n47,401;8,501", "line 2 has the latitude `47,401`, and that is a decimal comma: write 47.401"),
            ("lat,lon\n47,401,8,501", "line 2 has 4 numbers: decimal commas?"),
            ("47,401,8,501", "line 1 has 4 numbers: decimal commas?"),
            ("8.5,47.4,0", "with more than two a header tells"),
            ("name,height\na,3", "neither a latitude nor a longitude (`name`, `height`)"),
            ("name,lat\na,3", "no longitude"),
            ("WKT,name\nPOINT (8.5 47.4),a", "GEOMETRY=AS_XY"),
            ("lat,lon\n47.4,\n", "line 2 has no longitude"),
            ("lat,lon\n47.4,nan", "`nan`, and that is no number"),
            ("lat,lon\n47°24'N,8.5", "no decimal number of degrees"),
            ("lat,lon\n\"a\nb\",1\n", "line 2 has the latitude"),
            ("lat", "is one column"),
            ("x,y\n946326.9,6001234.5", "metres of a projection"),
            ("8.5,147.4", ""),
        ] {
            match read(text) {
                Err(fault) => assert!(fault.problem.contains(words), "{text}: {}", fault.problem),
                Ok(_) => assert!(words.is_empty(), "{text}"),
            }
        }
        assert!(said("147.4,8.5").contains("swapped"), "{}", said("147.4,8.5"));
    }
}
