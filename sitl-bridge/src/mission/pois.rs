//! Sensing: which PoIs a UAV sees.

use firmware_core::geometry::{OBSERVATION_RANGE_U, TICKS_PER_U, Vec2};

const RANGE: i32 = OBSERVATION_RANGE_U * TICKS_PER_U;

/// The PoIs of a mission by their place, so that a look costs what lies near. A UAV gets to
/// see only those in observation range, as a camera would show it.
#[derive(Clone, Debug)]
pub struct PoiMap {
    /// Ordered by x.
    by_x: Vec<Vec2>,
}

impl PoiMap {
    /// A map of these points, ticks.
    #[must_use]
    pub fn new(pois: &[Vec2]) -> Self {
        let mut by_x = pois.to_vec();
        by_x.sort_unstable();
        Self { by_x }
    }

    /// The PoIs within observation range of `position` (the limit is inside).
    pub fn seen_from(&self, position: Vec2) -> impl Iterator<Item = Vec2> {
        let from = self.by_x.partition_point(|p| p.x < position.x.saturating_sub(RANGE));
        let to = self.by_x.partition_point(|p| p.x <= position.x.saturating_add(RANGE));
        let strip = self.by_x.get(from..to).unwrap_or_default();
        strip.iter().copied().filter(move |&p| (p - position).within(RANGE).is_some())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn exactly_what_is_in_range_is_seen(
            pois in prop::collection::vec((-50_000i32..50_000, -50_000i32..50_000), 0..80),
            (x, y) in (-60_000i32..60_000, -60_000i32..60_000),
        ) {
            let pois: Vec<Vec2> = pois.into_iter().map(|(x, y)| Vec2 { x, y }).collect();
            let d2 = |p: &Vec2| i64::from(p.x - x).pow(2) + i64::from(p.y - y).pow(2);
            let mut expected: Vec<Vec2> = pois.iter().copied().filter(|p| d2(p) <= i64::from(RANGE).pow(2)).collect();
            expected.sort_unstable();
            let got: Vec<Vec2> = PoiMap::new(&pois).seen_from(Vec2 { x, y }).collect();
            prop_assert_eq!(got, expected);
        }
    }
}
