//! From what is written to a mission that can be flown.

use super::definition::{DEFAULT_MARGIN_U, Mission, square_fence};
use super::drawing::{Drawing, FARTHEST_LON, Order, Spot, turned_back};
use super::fault::{Fault, fault};
use super::file::{Decide, FenceFile, MissionFile, Origin};
use super::format::Format;
use super::height_warnings::height_warnings;
use super::outline::{Shaped, shape};
use super::plane::{OriginError, Plane, Scale, to_e7};
use super::poi_check::{Poi, PoiCheck};
use covey_env::Scenario;
use firmware_core::actor::Mode;
use firmware_core::geometry::{TICKS_PER_U, Vec2};
use firmware_core::neighbour_table::STEP_MS_LIMIT;

/// Steps shorter than this leave no time for two messages, ms.
const LEAST_STEP_MS: u16 = 200;
/// Longest side of a map, m: well inside the plane's reach.
pub(super) const LONGEST_SIDE_M: f64 = 10_000.0;
/// A corner in u is refused beyond this, u: more than the plane's reach at the least scale.
const FAR_U: f64 = 2.5e5;

/// A mission, and what its operator should know.
#[derive(Debug)]
pub(super) struct Checked {
    pub mission: Mission,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
}

/// Checks fields and drawing together.
pub(super) fn check(
    file: &MissionFile,
    origin: Origin,
    drawing: &Drawing,
    format: Format,
    simplify: bool,
) -> Result<Checked, Fault> {
    let prefix = if format == Format::GeoJson { "covey." } else { "" };
    let check = Check { file, drawing, format, prefix, simplify };
    check.mission(origin)
}

pub(super) struct Check<'a> {
    pub(super) file: &'a MissionFile,
    drawing: &'a Drawing,
    format: Format,
    /// Stands before the names of fields.
    prefix: &'static str,
    simplify: bool,
}

/// A point in degrees that is to be laid on the map.
struct Degrees<'s> {
    at: &'s str,
    lat: f64,
    lon: f64,
    order: Order,
}

impl Check<'_> {
    pub(super) fn fault(&self, field: &str, problem: impl std::fmt::Display) -> Fault {
        let named = format!("{}{field}", self.prefix);
        Fault { field: field.to_owned(), problem: format!("{named} {problem}") }
    }

    fn mission(&self, origin: Origin) -> Result<Checked, Fault> {
        let file = self.file;
        let is_turned = origin.lon.abs() > 180.0 && origin.lon.abs() <= FARTHEST_LON;
        let lon = if is_turned { turned_back(origin.lon) } else { origin.lon };
        let plane = Plane::new(origin.lat, lon, origin.alt_m).map_err(|e| match e {
            OriginError::Latitude(_) => self.fault("origin.lat", format!("is the {e}")),
            OriginError::Longitude(_) => self.fault("origin.lon", format!("is the {e}")),
            OriginError::Altitude(_) => self.fault("origin.alt_m", format!("is the {e}")),
        })?;
        self.within("scale_m", file.scale_m, 0.1, 100.0)?;
        self.within("step_ms", file.step_ms, LEAST_STEP_MS, STEP_MS_LIMIT)?;
        self.within("side_u", file.side_u, f64::from(Scenario::MIN_SIDE_U), f64::from(Scenario::MAX_SIDE_U))?;
        let side_m = file.side_u * file.scale_m;
        if side_m > LONGEST_SIDE_M {
            let problem = format!("× scale_m makes a map of {side_m} m; use {LONGEST_SIDE_M} m at most");
            return Err(self.fault("side_u", problem));
        }
        let scale = Scale { unit_m: file.scale_m, step_ms: file.step_ms };
        let layers = self.layers()?;
        let heights = self.heights()?;
        let Shaped { corners: fence, mut notes } = self.fence(&plane, scale)?;
        let pois = self.pois(&plane, scale)?;
        let mut mission = Mission {
            plane,
            scale,
            side_u: file.side_u,
            fence,
            layers,
            heights,
            pois: Vec::new(),
            policy_seed: file.policy_seed,
            mode: match file.decide {
                Decide::Sample => Mode::Sample,
                Decide::Argmax => Mode::Argmax,
            },
            epoch_unix_ms: file.epoch_unix_ms,
        };
        let checked = PoiCheck::of(&mission, pois);
        let count = checked.on_map.len();
        if count == 0 {
            return Err(self.nothing_to_cover(&checked));
        }
        if count > Scenario::MAX_POIS {
            return Err(self.fault("pois_u", format!("has {count} points; use {} at most", Scenario::MAX_POIS)));
        }
        let mut warnings = checked.warnings(&mission);
        warnings.extend(height_warnings(&mission));
        mission.pois = checked.on_map.iter().map(|poi| poi.place).collect();
        notes.extend(is_turned.then(|| format!("{}origin.lon: {} is {lon}", self.prefix, origin.lon)));
        notes.extend(self.altitudes());
        Ok(Checked { mission, notes, warnings })
    }

    fn nothing_to_cover(&self, checked: &PoiCheck) -> Fault {
        let Some(first) = checked.off_map.first() else {
            let problem = match self.format {
                Format::Toml => "pois_u and pois_lat_lon are both empty; a mission has something to cover",
                Format::GeoJson => "there is no point in it; a mission has something to cover: draw PoIs as Points",
                Format::Kml => "there is no point in it; a mission has something to cover: set placemarks",
                Format::Csv => "there is no row with a point in it; a mission has something to cover",
                Format::Plan | Format::Waypoints => "there is no waypoint in it; a mission has something to cover",
            };
            // Why those that are there do not count.
            let told: Vec<_> = self.drawing.notes.iter().take(3).map(String::as_str).collect();
            let told = if told.is_empty() { String::new() } else { format!(" ({})", told.join("; ")) };
            return Fault { field: "pois_u".into(), problem: format!("{problem}{told}") };
        };
        let (x, y) = first.place.to_u();
        let count = checked.off_map.len();
        let all = if count == 1 { "its only PoI lies".into() } else { format!("all {count} PoIs lie") };
        let side = self.file.side_u;
        Fault {
            field: first.field.clone(),
            problem: format!(
                "{all} outside the map of 0 to {side} u: {} is at ({x:.1}, {y:.1}) u from the origin. Move the origin, the map's \
                 south-west corner, or make side_u larger",
                first.at
            ),
        }
    }

    fn pois(&self, plane: &Plane, scale: Scale) -> Result<Vec<Poi>, Fault> {
        let file = self.file;
        let mut pois = Vec::with_capacity(file.pois_u.len() + file.pois_lat_lon.len() + self.drawing.pois.len());
        for (i, &[x, y]) in file.pois_u.iter().enumerate() {
            let field = format!("pois_u[{i}]");
            if !(x.is_finite() && y.is_finite()) {
                return Err(self.fault(&field, format!("is at ({x}, {y}) u: that is no number")));
            }
            // To ticks first: a point at the very edge is inside, whichever way it rounds.
            let place = Mission::ticks_of_u(x, y);
            pois.push(Poi { at: format!("{}{field}", self.prefix), field, place, alt_m: None });
        }
        for (i, &[lat, lon]) in file.pois_lat_lon.iter().enumerate() {
            let field = format!("pois_lat_lon[{i}]");
            let at = format!("{}{field}", self.prefix);
            let spot = Drawing::new(Order::LatLon)
                .spot(&at, lat, lon, None)
                .map_err(|f| Fault { field: field.clone(), ..f })?;
            let degrees = Degrees { at: &at, lat: spot.lat, lon: spot.lon, order: Order::LatLon };
            let place = self.lay(&degrees, plane, scale, true).map_err(|f| Fault { field: field.clone(), ..f })?;
            pois.push(Poi { at, field, place, alt_m: None });
        }
        for Spot { at, lat, lon, alt_m } in &self.drawing.pois {
            let degrees = Degrees { at, lat: *lat, lon: *lon, order: self.drawing.order };
            let place = self.lay(&degrees, plane, scale, true)?;
            pois.push(Poi { at: at.clone(), field: String::new(), place, alt_m: *alt_m });
        }
        Ok(pois)
    }

    fn fence(&self, plane: &Plane, scale: Scale) -> Result<Shaped, Fault> {
        let FenceFile { margin_u, polygon_u, polygon_lat_lon } = &self.file.fence;
        let forms = [margin_u.is_some(), polygon_u.is_some(), polygon_lat_lon.is_some(), self.drawing.fence.is_some()];
        if forms.iter().filter(|&&given| given).count() > 1 {
            let drawn = self.drawing.fence.as_ref().map(|f| format!(", or draw one like {}", f.at)).unwrap_or_default();
            let problem = format!("has more than one form; give margin_u, polygon_u or polygon_lat_lon{drawn}");
            return Err(self.fault("fence", problem));
        }
        let (at, field, corners) = if let Some(corners) = polygon_u {
            let field = "fence.polygon_u";
            for &[x, y] in corners {
                if !(x.abs() <= FAR_U && y.abs() <= FAR_U) {
                    return Err(self.fault(field, format!("has the corner ({x}, {y}) u, far off the map")));
                }
            }
            // Corners lie beyond the map too, where f32 has no place for each tick.
            let ticks = |u: f64| (u * f64::from(TICKS_PER_U)).round() as i32;
            let corners = corners.iter().map(|&[x, y]| Vec2::from_ticks(ticks(x), ticks(y))).collect::<Vec<_>>();
            (format!("{}{field}", self.prefix), field, corners)
        } else if let Some(corners) = polygon_lat_lon {
            let field = "fence.polygon_lat_lon";
            let at = format!("{}{field}", self.prefix);
            let named = |f: Fault| Fault { field: field.into(), ..f };
            let corner = |&[lat, lon]: &[f64; 2]| {
                let spot = Drawing::new(Order::LatLon).spot(&at, lat, lon, None)?;
                self.lay(&Degrees { at: &at, lat: spot.lat, lon: spot.lon, order: Order::LatLon }, plane, scale, false)
            };
            let corners = corners.iter().map(corner).collect::<Result<Vec<_>, _>>().map_err(named)?;
            (at, field, corners)
        } else if let Some(outline) = &self.drawing.fence {
            let order = self.drawing.order;
            let corner =
                |s: &Spot| self.lay(&Degrees { at: &s.at, lat: s.lat, lon: s.lon, order }, plane, scale, false);
            let corners = outline.corners.iter().map(corner).collect::<Result<Vec<_>, _>>()?;
            (outline.at.clone(), "", corners)
        } else {
            let margin = margin_u.unwrap_or(DEFAULT_MARGIN_U);
            self.within("fence.margin_u", margin, 0.0, 1000.0)?;
            return Ok(Shaped { corners: square_fence(self.file.side_u, margin), notes: Vec::new() });
        };
        let shaped = shape(&corners, scale, self.simplify)
            .map_err(|problem| Fault { field: field.into(), ..fault(&at, problem) })?;
        let notes = shaped.notes.iter().map(|note| format!("{at}: {note}")).collect();
        Ok(Shaped { corners: shaped.corners, notes })
    }

    /// A position on the map's plane. Where it lies on the map only with its numbers swapped, they are.
    fn lay(&self, degrees: &Degrees<'_>, plane: &Plane, scale: Scale, is_poi: bool) -> Result<Vec2, Fault> {
        let &Degrees { at, lat, lon, order } = degrees;
        let side = Mission::ticks_of_u(self.file.side_u, self.file.side_u).x;
        let margin = if is_poi { 0 } else { side };
        let on_map = |p: &Vec2| (-margin..=side + margin).contains(&p.x) && (-margin..=side + margin).contains(&p.y);
        let place = on_plane(plane, scale, lat, lon);
        if let Some(place) = place.filter(on_map) {
            return Ok(place);
        }
        let words = order.words(lat, lon);
        let swapped = on_plane(plane, scale, lon, lat).filter(|p| place.is_none() || on_map(p));
        if swapped.is_some() {
            // Where nothing else lies near it, it may be the origin that is wrong.
            let where_from = if self.is_near(plane) { "" } else { ", here or in the origin" };
            let rule = order.rule();
            let problem = format!(
                "is at {words}, far off the map, and near when swapped: latitude and longitude are swapped{where_from}; {rule}"
            );
            return Err(fault(at, problem));
        }
        place.ok_or_else(|| {
            let (olat, olon) = plane.origin_degrees();
            let km = plane.distance_km(lat, lon);
            let problem = format!(
                "is at {words}, {km:.0} km from the origin at latitude {olat}, longitude {olon}; 20 km is the limit"
            );
            fault(at, problem)
        })
    }

    /// Whether any position in degrees lies near the origin.
    fn is_near(&self, plane: &Plane) -> bool {
        let corners = self.drawing.fence.iter().flat_map(|fence| &fence.corners);
        let drawn = self.drawing.pois.iter().chain(corners).map(|spot| [spot.lat, spot.lon]);
        let listed = self.file.pois_lat_lon.iter().chain(self.file.fence.polygon_lat_lon.iter().flatten()).copied();
        let scale = Scale { unit_m: 1.0, step_ms: LEAST_STEP_MS };
        drawn.chain(listed).any(|[lat, lon]| on_plane(plane, scale, lat, lon).is_some())
    }

    /// A word on altitudes, which a mission does not use.
    fn altitudes(&self) -> Option<String> {
        let mut with = self.drawing.pois.iter().filter(|p| p.alt_m.is_some_and(|alt| alt != 0.0)).peekable();
        let first = with.peek()?.at.clone();
        Some(format!(
            "altitudes of points are not used ({} have one, {first} first): UAVs fly in their layers",
            with.count()
        ))
    }

    pub(super) fn within<T: PartialOrd + std::fmt::Display + Copy>(
        &self,
        field: &str,
        value: T,
        low: T,
        high: T,
    ) -> Result<(), Fault> {
        if value >= low && value <= high {
            return Ok(());
        }
        Err(self.fault(field, format!("= {value}; use {low} to {high}")))
    }
}

fn on_plane(plane: &Plane, scale: Scale, lat: f64, lon: f64) -> Option<Vec2> {
    let sound = (-90.0..=90.0).contains(&lat) && (-180.0..=180.0).contains(&lon);
    sound.then(|| plane.place(to_e7(lat), to_e7(lon))).flatten().map(|place| scale.position(place))
}
