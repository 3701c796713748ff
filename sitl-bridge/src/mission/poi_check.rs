//! PoIs that no UAV can cover, or that are there twice: what the operator should hear before the flight.

use super::definition::Mission;
use firmware_core::gate::{Limits, Vector};
use firmware_core::geometry::{COVERAGE_RANGE_U, Vec2};

/// So many are named; of more only the number is said.
const NAMED: usize = 3;

/// A PoI with its name in the file.
#[derive(Clone, Debug)]
pub(super) struct Poi {
    /// As it is told.
    pub at: String,
    /// The field of a TOML file, by which its line is found.
    pub field: String,
    pub place: Vec2,
    /// Above mean sea level, m.
    pub alt_m: Option<f64>,
}

/// The PoIs of a mission, looked over.
#[derive(Debug)]
pub(super) struct PoiCheck {
    pub on_map: Vec<Poi>,
    pub off_map: Vec<Poi>,
}

impl PoiCheck {
    pub(super) fn of(mission: &Mission, pois: Vec<Poi>) -> Self {
        let side = Mission::ticks_of_u(mission.side_u, mission.side_u).x;
        let on_map = |p: &Poi| (0..=side).contains(&p.place.x) && (0..=side).contains(&p.place.y);
        let (on_map, off_map) = pois.into_iter().partition(on_map);
        Self { on_map, off_map }
    }

    /// One line for each kind of trouble.
    pub(super) fn warnings(&self, mission: &Mission) -> Vec<String> {
        let all = self.on_map.len();
        let mut warnings = Vec::new();
        let in_u = |poi: &Poi| {
            let (x, y) = poi.place.to_u();
            format!("{} at ({x:.1}, {y:.1}) u", poi.at)
        };
        if !self.off_map.is_empty() {
            let off: Vec<_> = self.off_map.iter().collect();
            warnings.push(format!(
                "{} beyond the map of 0 to {} u and left out: {}",
                lie(off.len(), all + off.len()),
                mission.side_u,
                some(&off, in_u)
            ));
        }
        warnings.extend(self.fenced(mission, in_u));
        if let Some(warning) = self.doubled() {
            warnings.push(warning);
        }
        let lowest_m = f64::from(mission.plane.alt_mm) / 1000.0 + mission.layers.base_m;
        let high: Vec<_> = self.on_map.iter().filter(|p| p.alt_m.is_some_and(|alt| alt > lowest_m)).collect();
        if !high.is_empty() {
            let named = some(&high, |p| format!("{} at {} m", p.at, p.alt_m.unwrap_or_default()));
            warnings.push(format!(
                "{} higher than the lowest layer ({lowest_m} m above sea level), whose UAVs fly below: {named}",
                lie(high.len(), all)
            ));
        }
        warnings
    }

    /// Outside the fence, and out of reach from where the gate lets UAVs fly.
    fn fenced(&self, mission: &Mission, in_u: impl Fn(&Poi) -> String + Copy) -> Vec<String> {
        let Ok(fence) = mission.gate_fence() else { return Vec::new() };
        let unit_mm = mission.scale.unit_m * 1000.0;
        let covers_mm = (f64::from(COVERAGE_RANGE_U) * unit_mm) as i64;
        let margin_mm = i64::from(Limits::default().fence_margin_mm);
        let depth_mm = |poi: &Poi| {
            let place = mission.scale.place(poi.place);
            i64::from(fence.depth_mm(Vector::new(place.east_mm.round() as i32, place.north_mm.round() as i32)))
        };
        let all = self.on_map.len();
        let (mut outside, mut reached, mut near) = (Vec::new(), 0, Vec::new());
        for poi in &self.on_map {
            let depth = depth_mm(poi);
            let is_covered = depth + covers_mm >= margin_mm;
            if depth < 0 {
                outside.push(poi);
                reached += usize::from(is_covered);
            } else if !is_covered {
                near.push(poi);
            }
        }
        let mut warnings = Vec::new();
        let covers_m = covers_mm as f64 / 1000.0;
        if !outside.is_empty() {
            let reach = match (reached, outside.len()) {
                (0, _) => "none can be covered from inside".to_owned(),
                (n, m) if n == m => format!("they can be covered from inside, within {covers_m} m"),
                (n, _) => format!("{n} of them can be covered from inside, within {covers_m} m"),
            };
            warnings.push(format!(
                "{} outside the fence, where no UAV flies; {reach}: {}",
                lie(outside.len(), all),
                some(&outside, in_u)
            ));
        }
        if !near.is_empty() {
            warnings.push(format!(
                "{} so near to the fence that no UAV can cover them: the safety gate keeps {} m away from it, and UAVs cover \
                 what lies within {covers_m} m: {}",
                lie(near.len(), all),
                margin_mm as f64 / 1000.0,
                some(&near, in_u)
            ));
        }
        warnings
    }

    fn doubled(&self) -> Option<String> {
        let mut order: Vec<usize> = (0..self.on_map.len()).collect();
        order.sort_by_key(|&i| (self.on_map[i].place, i));
        let mut again: Vec<(usize, usize)> = Vec::new();
        let mut first = *order.first()?;
        for &i in order.iter().skip(1) {
            if self.on_map[i].place == self.on_map[first].place {
                again.push((i, first));
            } else {
                first = i;
            }
        }
        if again.is_empty() {
            return None;
        }
        again.sort_unstable();
        let name = |&(i, first): &(usize, usize)| format!("{} as {}", self.on_map[i].at, self.on_map[first].at);
        let verb = if again.len() == 1 { "lies" } else { "lie" };
        Some(format!(
            "{} of {} PoIs {verb} where another does, and each counts: {}",
            again.len(),
            self.on_map.len(),
            some(&again.iter().collect::<Vec<_>>(), name)
        ))
    }
}

/// `1 PoI lies`, `3 of 12 PoIs lie`, `all 12 PoIs lie`.
fn lie(count: usize, all: usize) -> String {
    match (count, all) {
        (1, 1) => "the only PoI lies".into(),
        (n, m) if n == m => format!("all {m} PoIs lie"),
        (1, m) => format!("1 of {m} PoIs lies"),
        (n, m) => format!("{n} of {m} PoIs lie"),
    }
}

/// The first few by name.
fn some<T>(items: &[&T], name: impl Fn(&T) -> String) -> String {
    let mut named: Vec<_> = items.iter().take(NAMED).map(|item| name(item)).collect();
    if items.len() > NAMED {
        named.push(format!("and {} more", items.len() - NAMED));
    }
    named.join(", ")
}
