//! The PoIs that a UAV knows of.

use super::point::{GRID, GridPoint};
use super::since::Since;
use crate::geometry::{OBSERVATION_RANGE_U, TICKS_PER_U, Vec2};
use heapless::Vec;

/// PoIs that a memory holds. When there are more, those nearest to the UAV stay.
pub const POI_CAPACITY: usize = 64;
/// A PoI that nobody has seen for more steps than this is forgotten.
pub const POI_MAX_AGE: u8 = 126;

/// Within this distance (ticks) a remembered PoI must be seen, or it is not there: the view, less what the grid
/// rounds off.
const MUST_SEE: i32 = OBSERVATION_RANGE_U * TICKS_PER_U - GRID;

/// A PoI that a UAV knows of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownPoi {
    /// Where it is.
    pub at: GridPoint,
    /// Steps since somebody saw it, 0 to [`POI_MAX_AGE`].
    pub age: u8,
    /// Steps since this UAV told of it.
    told: Since,
}

/// Known PoIs in the order of their squares.
#[derive(Clone, Debug, Default)]
pub(super) struct KnownPois(Vec<KnownPoi, POI_CAPACITY>);

impl KnownPois {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    pub(super) fn as_slice(&self) -> &[KnownPoi] {
        &self.0
    }

    /// Everything is `steps` older.
    pub(super) fn advance(&mut self, steps: u8) {
        self.0.retain_mut(|p| {
            p.age = p.age.saturating_add(steps);
            p.told.advance(steps);
            p.age <= POI_MAX_AGE
        });
    }

    /// Takes in a PoI that was seen `age` steps ago. `own` is where the UAV is (ticks): when there is no room the
    /// farthest goes.
    pub(super) fn insert(&mut self, at: GridPoint, age: u8, own: Vec2) {
        if age > POI_MAX_AGE {
            return;
        }
        match self.0.binary_search_by(|p| p.at.cmp(&at)) {
            Ok(k) => {
                if let Some(known) = self.0.get_mut(k) {
                    known.age = known.age.min(age);
                }
            }
            Err(_) => self.add(KnownPoi { at, age, told: Since::NEVER }, own),
        }
    }

    fn add(&mut self, poi: KnownPoi, own: Vec2) {
        if self.0.is_full() {
            let farthest = self.0.iter().enumerate().max_by_key(|(_, p)| (p.at.distance2(own), p.at));
            match farthest {
                Some((k, p)) if (poi.at.distance2(own), poi.at) < (p.at.distance2(own), p.at) => self.remove(k),
                _ => return,
            }
        }
        // Not full any more.
        let _ = self.0.push(poi);
        for end in (2..=self.0.len()).rev() {
            match self.0.get_mut(..end) {
                Some([.., a, b]) if b.at < a.at => core::mem::swap(a, b),
                _ => return,
            }
        }
    }

    fn remove(&mut self, k: usize) {
        let mut index = 0;
        self.0.retain(|_| {
            let stays = index != k;
            index += 1;
            stays
        });
    }

    /// Forgets the PoIs that the UAV should see from `own` and has not seen in this step.
    pub(super) fn forget_missing(&mut self, own: Vec2) {
        self.0.retain(|p| p.age == 0 || (p.at.middle() - own).within(MUST_SEE).is_none());
    }

    /// The PoI told least recently of those not told in this step; of equal ones the one seen last, then by square. It
    /// counts as told from now on.
    pub(super) fn next_to_tell(&mut self) -> Option<(GridPoint, u8)> {
        // The first of the greatest: of equal ones the south-westernmost.
        let key = |p: &KnownPoi| (p.told, core::cmp::Reverse(p.age), core::cmp::Reverse(p.at));
        let next = self.0.iter_mut().filter(|p| p.told > Since::NOW).max_by_key(|p| key(p))?;
        next.told = Since::NOW;
        Some((next.at, next.age))
    }
}
