//! What a UAV knows of the intentions of others.

use super::point::GridPoint;
use super::since::Since;
use crate::geometry::{SPEED_CAP_U, TICKS_PER_U, Vec2};
use heapless::Vec;

/// UAVs whose intentions a memory holds. When there are more, those stay whose targets are nearest.
pub const REPORT_CAPACITY: usize = 32;
/// An intention that nobody has told for more steps than this is forgotten.
pub const REPORT_MAX_AGE: u8 = 31;
/// Most steps until the arrival that are told; longer flights count as this.
pub const MAX_ARRIVAL: u8 = 31;

/// A UAV that must have arrived within this distance (ticks), and was not heard for …
const EXPECTED_WITHIN: i32 = 16 * TICKS_PER_U;
/// … this many steps, is not there.
const UNHEARD_STEPS: u8 = 3;

/// Where another UAV is going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Its id.
    pub id: u16,
    /// Where it is going.
    pub target: GridPoint,
    /// Steps of its flight there when it told, 0 to [`MAX_ARRIVAL`].
    pub arrival: u8,
    /// Steps since it told, 0 to [`REPORT_MAX_AGE`].
    pub age: u8,
    /// Steps since this UAV passed it on.
    told: Since,
}

impl Report {
    /// UAV `id` told `age` steps ago that it would arrive in `arrival` steps.
    #[must_use]
    pub const fn new(id: u16, target: GridPoint, arrival: u8, age: u8) -> Self {
        Self { id, target, arrival, age, told: Since::NEVER }
    }

    /// Steps until it arrives, if it flies on.
    #[must_use]
    pub const fn steps_left(&self) -> u8 {
        self.arrival.saturating_sub(self.age)
    }
}

/// Steps of a flight (ticks) at full speed, rounded up, at most [`MAX_ARRIVAL`].
#[must_use]
pub fn flight_steps(offset: Vec2) -> u8 {
    const STEP: u32 = (SPEED_CAP_U * TICKS_PER_U) as u32;
    const FAR: u32 = STEP * MAX_ARRIVAL as u32;
    let (x, y) = (offset.x.unsigned_abs().min(FAR), offset.y.unsigned_abs().min(FAR));
    // Below 2 · 2^34 in 64 bits.
    let far = (u64::from(x) * u64::from(x) + u64::from(y) * u64::from(y)).isqrt() as u32;
    far.div_ceil(STEP).min(u32::from(MAX_ARRIVAL)) as u8
}

/// Known intentions.
#[derive(Clone, Debug, Default)]
pub(super) struct Reports(Vec<Report, REPORT_CAPACITY>);

impl Reports {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    pub(super) fn as_slice(&self) -> &[Report] {
        &self.0
    }

    /// Everything is `steps` older.
    pub(super) fn advance(&mut self, steps: u8) {
        self.0.retain_mut(|r| {
            r.age = r.age.saturating_add(steps);
            r.told.advance(steps);
            r.age <= REPORT_MAX_AGE
        });
    }

    /// Takes in a report; the newer one of a UAV stays. `own` is where this UAV is (ticks).
    pub(super) fn insert(&mut self, report: Report, own: Vec2) {
        if report.age > REPORT_MAX_AGE {
            return;
        }
        if let Some(known) = self.0.iter_mut().find(|r| r.id == report.id) {
            if report.age < known.age || report.age == 0 {
                let told = known.told;
                *known = Report { told, ..report };
            }
            return;
        }
        let Err(report) = self.0.push(report) else { return };
        let rank = |r: &Report| (r.target.distance2(own), r.id);
        match self.0.iter_mut().max_by_key(|r| rank(r)) {
            Some(farthest) if rank(&report) < rank(farthest) => *farthest = report,
            _ => {}
        }
    }

    /// Forgets the UAVs that should be near `own` by now and have not been heard.
    pub(super) fn forget_missing(&mut self, own: Vec2) {
        self.0.retain(|r| {
            let gone = r.age >= UNHEARD_STEPS
                && r.steps_left() == 0
                && (r.target.middle() - own).within(EXPECTED_WITHIN).is_some();
            !gone
        });
    }

    /// The report passed on least recently of those not passed on in this step; of equal ones the newest, then the
    /// lowest id. It counts as passed on from now on.
    pub(super) fn next_to_tell(&mut self) -> Option<Report> {
        let key = |r: &Report| (r.told, core::cmp::Reverse(r.age), core::cmp::Reverse(r.id));
        let next = self.0.iter_mut().filter(|r| r.told > Since::NOW).max_by_key(|r| key(r))?;
        next.told = Since::NOW;
        Some(*next)
    }
}
