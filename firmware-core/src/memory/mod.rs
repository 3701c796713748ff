//! What a UAV remembers, and what it passes on.
//!
//! A [`Memory`] holds what the UAV has seen or heard of: [PoIs](KnownPoi) with the steps since somebody saw them, the area
//! that somebody has looked at, and where [other UAVs](Report) are going. It passes [`Knowledge`] on, hop by hop, in a
//! budget of bytes a step. Everything is whole numbers of fixed capacity; `docs/memory.md` has the rules and the layout.
//!
//! A step goes like this:
//!
//! 1. [`Memory::begin`]: the UAV looks;
//! 2. [`Memory::tell`]: what to send to the neighbours;
//! 3. [`Memory::hear`] and [`Memory::hear_target`]: what they sent;
//! 4. [`Memory::settle`]: what must be here by now and is not, is forgotten.
//!
//! Messages may be lost, late or doubled, and come in any order: of two facts the newer stays, and a fact's age travels
//! with it. After a reboot a memory is empty. What a hostile neighbour with the swarm's key can add lies on the map, is no
//! younger than a step, and is gone [`POI_MAX_AGE`] and [`REPORT_MAX_AGE`] steps after its last word; while it lies in view
//! and is not there, it is forgotten at once. It can displace what lies farther away, say of any UAV that it goes elsewhere
//! until that UAV is heard again, and call area explored; PoIs in view it cannot hide.

mod area;
mod knowledge;
mod point;
mod pois;
mod reports;
mod since;
#[cfg(test)]
mod tests;

pub use area::{BLOCK, CELL, WINDOW};
pub use knowledge::{BLOCK_LEN, Knowledge, MAX_KNOWLEDGE, MAX_REPORT_ID, POI_LEN, REPORT_LEN};
pub use point::{GRID, GridPoint};
pub use pois::{KnownPoi, POI_CAPACITY, POI_MAX_AGE};
pub use reports::{MAX_ARRIVAL, REPORT_CAPACITY, REPORT_MAX_AGE, Report, flight_steps};

use crate::geometry::{COORDINATE_LIMIT, OBSERVATION_RANGE_U, TICKS_PER_U, Vec2};
use crate::observation::HALF_SIDE_LIMIT;
use area::ExploredArea;
use knowledge::Frame;
use pois::KnownPois;
use reports::Reports;
use since::Since;

/// After a gap of more steps than this a memory starts empty.
pub const MAX_GAP: u32 = POI_MAX_AGE as u32;

/// The memory of one UAV, less than 1 KiB.
#[derive(Clone, Debug)]
pub struct Memory {
    id: u16,
    half_side: i32,
    /// The step begun last.
    step: Option<u32>,
    /// Where the UAV was then, ticks.
    own: Vec2,
    pois: KnownPois,
    area: ExploredArea,
    reports: Reports,
    /// Which ids modulo 64 were heard in this step and in the one before, a bit each. Of two that share a bit a newcomer
    /// may be missed: it then waits for its turn.
    heard: [u64; 2],
    /// Steps since a neighbour was heard that had not been heard in the step before.
    newest_neighbour: Since,
}

impl Memory {
    /// A memory of UAV `id` that knows nothing, for a map of this half side (ticks, 1 to [`HALF_SIDE_LIMIT`]; what is
    /// outside counts as the nearest). The map's south-west corner is the origin.
    #[must_use]
    pub const fn new(id: u16, half_side: i32) -> Self {
        Self {
            id,
            half_side: valid_half_side(half_side),
            step: None,
            own: Vec2 { x: 0, y: 0 },
            pois: KnownPois::new(),
            area: ExploredArea::new(),
            reports: Reports::new(),
            heard: [0; 2],
            newest_neighbour: Since::NEVER,
        }
    }

    /// Becomes [`Self::new`] in place, for boards whose stack has no room for a memory.
    pub fn reset(&mut self, id: u16, half_side: i32) {
        (self.id, self.half_side) = (id, valid_half_side(half_side));
        self.forget();
    }

    fn forget(&mut self) {
        self.step = None;
        self.pois.clear();
        self.area.clear();
        self.reports.clear();
        (self.heard, self.newest_neighbour) = ([0; 2], Since::NEVER);
    }

    /// Begins the step `step`: everything ages, and the UAV at `own` (ticks) looks at the PoIs at `pois` (ticks; those out of
    /// view are left out). Steps wrap around; a step that is not at most [`MAX_GAP`] ahead of the last one leaves an
    /// empty memory. Beginning a step again only looks again.
    pub fn begin(&mut self, step: u32, own: Vec2, pois: impl IntoIterator<Item = Vec2>) {
        let passed = self.step.map_or(0, |last| step.wrapping_sub(last));
        if passed > MAX_GAP {
            self.forget();
        } else if passed > 0 {
            // At most MAX_GAP.
            self.advance(passed as u8);
        }
        self.step = Some(step);
        self.own = own;
        // A UAV beyond the edge looks at what the map has there.
        let most = self.most();
        let inside = on_map(own, most);
        self.area.move_to(inside, self.half_side);
        self.area.look(inside);
        const VIEW: i32 = OBSERVATION_RANGE_U * TICKS_PER_U;
        for poi in pois.into_iter().filter(|&p| (p - own).within(VIEW).is_some() && is_on_map(p, most)) {
            self.pois.insert(GridPoint::of(poi), 0, own);
        }
        self.pois.forget_missing(own);
    }

    fn advance(&mut self, steps: u8) {
        self.pois.advance(steps);
        self.reports.advance(steps);
        self.area.advance(steps);
        self.newest_neighbour.advance(steps);
        self.heard = [0, if steps == 1 { self.heard[0] } else { 0 }];
    }

    /// Writes to `out` what to pass on in this step, in at most `budget` bytes (and [`MAX_KNOWLEDGE`]).
    ///
    /// Two fifths are for reports, the rest in halves for PoIs and the explored area; what one does not need goes to the
    /// next. PoIs and reports go by turns: those told least recently first. Of the area those blocks come first that have
    /// changed since they were told or that a new neighbour was not told, then the nearest.
    pub fn tell(&mut self, budget: usize, out: &mut Knowledge) {
        out.clear();
        let frame = self.frame(GridPoint::of(self.own));
        let mut left = budget.min(MAX_KNOWLEDGE);
        let reports = (left * 2 / 5 / REPORT_LEN).min(self.reports.as_slice().len());
        left -= reports * REPORT_LEN;
        let blocks = left / 2 / BLOCK_LEN;
        let pois = (left - blocks * BLOCK_LEN) / POI_LEN;
        while usize::from(out.counts()[0]) < pois {
            let Some((at, age)) = self.pois.next_to_tell() else { break };
            out.add_poi(frame, at, age);
        }
        left -= usize::from(out.counts()[0]) * POI_LEN;
        while usize::from(out.counts()[1]) < reports {
            let Some(report) = self.reports.next_to_tell() else { break };
            out.add_report(frame, &report);
        }
        let blocks = left / BLOCK_LEN;
        while usize::from(out.counts()[2]) < blocks {
            let Some((place, cells)) = self.area.next_to_tell(self.own, self.newest_neighbour) else { break };
            out.add_block(place, cells);
        }
    }

    /// Takes in what UAV `id`, which tells that it is at `sender` (ticks), passed on in this step.
    pub fn hear(&mut self, id: u16, sender: Vec2, knowledge: &Knowledge) {
        self.meet(id);
        let sender = GridPoint::of(sender);
        let frame = self.frame(sender);
        for (at, age) in knowledge.pois(frame) {
            // What is there now, only the own eyes tell.
            self.pois.insert(at, age.max(1), self.own);
        }
        for report in knowledge.reports(frame).filter(|r| r.id != self.id) {
            // What somebody intends now, only he tells.
            self.reports.insert(Report::new(report.id, report.target, report.arrival, report.age.max(1)), self.own);
        }
        for (place, cells) in knowledge.blocks() {
            self.area.insert(place, cells, sender);
        }
    }

    /// Takes in where UAV `id` itself says in this step that it is going (ticks), and in how many steps it will be there.
    /// The last word counts.
    pub fn hear_target(&mut self, id: u16, target: Vec2, arrival: u8) {
        if id != self.id {
            let target = GridPoint::of(on_map(target, self.most()));
            self.reports.insert(Report::new(id, target, arrival.min(MAX_ARRIVAL), 0), self.own);
        }
    }

    /// All messages of the step have been heard: forgets the PoIs that the UAV should see and does not, and the UAVs that
    /// should be near and were not heard.
    pub fn settle(&mut self) {
        self.pois.forget_missing(self.own);
        self.reports.forget_missing(self.own);
    }

    fn meet(&mut self, id: u16) {
        let bit = 1u64 << (id % 64);
        if self.heard[1] & bit == 0 && self.heard[0] & bit == 0 {
            self.newest_neighbour = Since::NOW;
        }
        self.heard[0] |= bit;
    }

    /// The PoIs, in the order of their squares: at most [`POI_CAPACITY`].
    #[must_use]
    pub fn pois(&self) -> &[KnownPoi] {
        self.pois.as_slice()
    }

    /// Where others are going, in no order that means anything: at most [`REPORT_CAPACITY`].
    #[must_use]
    pub fn reports(&self) -> &[Report] {
        self.reports.as_slice()
    }

    /// Whether somebody has looked at the cell around a position (ticks). Beyond the map and the window nobody has.
    #[must_use]
    pub fn is_explored(&self, at: Vec2) -> bool {
        self.area.is_explored(at)
    }

    /// The map's greatest coordinate, ticks.
    const fn most(&self) -> i32 {
        2 * self.half_side - 1
    }

    fn frame(&self, sender: GridPoint) -> Frame {
        Frame { sender, side: (2 * self.half_side).unsigned_abs().div_ceil(GRID.unsigned_abs()) }
    }
}

/// The nearest position on the map, whose greatest coordinate is `most`.
fn on_map(p: Vec2, most: i32) -> Vec2 {
    // `clamp` would have a panic branch, as nothing says here that `most` is above 0.
    let axis = |t: i32| t.min(most).max(0);
    Vec2 { x: axis(p.x), y: axis(p.y) }
}

/// Whether a position lies on the map, whose greatest coordinate is `most`.
fn is_on_map(p: Vec2, most: i32) -> bool {
    (0..=most).contains(&p.x) && (0..=most).contains(&p.y)
}

const fn valid_half_side(half_side: i32) -> i32 {
    if half_side < 1 {
        1
    } else if half_side > HALF_SIDE_LIMIT {
        HALF_SIDE_LIMIT
    } else {
        half_side
    }
}

// Sums of positions and windows fit.
const _: () = assert!(2 * HALF_SIDE_LIMIT < COORDINATE_LIMIT);
// What the documents promise a board.
const _: () = assert!(size_of::<Memory>() < 1024);
