//! The area that somebody has looked at.

use super::point::GridPoint;
use super::since::Since;
use crate::geometry::{TICKS_PER_U, Vec2};

/// Side of a cell, ticks: 10 u.
pub const CELL: i32 = 10 * TICKS_PER_U;
/// Cells along a side of the window that a memory holds: 240 u.
pub const WINDOW: usize = 24;
/// Cells along a side of a block, which is told as a whole.
pub const BLOCK: usize = 4;
/// Blocks along a side of the window.
pub(super) const BLOCKS: usize = WINDOW / BLOCK;

/// A cell is seen from within this distance of its middle, ticks: 12.5 u.
const SEEN_FROM: i32 = 25 * TICKS_PER_U / 2;
/// On maps larger than the window a sender tells of blocks at most so many from its own.
const TOLD_BLOCKS: i32 = 2;

/// Steps since a block was told and since it changed.
#[derive(Clone, Copy, Debug)]
struct Ages {
    told: Since,
    changed: Since,
}

/// Cells that this UAV, or one that it heard of, has looked at.
///
/// The window of [`WINDOW`] × [`WINDOW`] cells lies around the UAV, moved so far that it does not leave the map. Where it
/// moves on, what it leaves is forgotten. On maps up to 240 u it holds the whole map.
#[derive(Clone, Debug)]
pub(super) struct ExploredArea {
    /// The window's south-west cell, at a corner of a block.
    first: [u16; 2],
    /// Cells along a side of the map.
    side: u16,
    /// Bit x mod 24 of row y mod 24.
    rows: [u32; WINDOW],
    ages: [[Ages; BLOCKS]; BLOCKS],
}

impl ExploredArea {
    pub(super) const fn new() -> Self {
        let ages = [[Ages { told: Since::NEVER, changed: Since::NEVER }; BLOCKS]; BLOCKS];
        Self { first: [0; 2], side: WINDOW as u16, rows: [0; WINDOW], ages }
    }

    pub(super) fn clear(&mut self) {
        *self = Self::new();
    }

    /// Everything is `steps` older.
    pub(super) fn advance(&mut self, steps: u8) {
        for ages in self.ages.iter_mut().flatten() {
            ages.told.advance(steps);
            ages.changed.advance(steps);
        }
    }

    /// Moves the window to a UAV at `own` (ticks), on a map of this half side (ticks).
    pub(super) fn move_to(&mut self, own: Vec2, half_side: i32) {
        self.side = ((2 * half_side + CELL - 1) / CELL).clamp(1, 1 << 11) as u16;
        let axis = |t: i32| {
            let most = (i32::from(self.side) - WINDOW as i32).max(0);
            // Whole blocks, so that a block is never half in the window.
            let first = (t / CELL - WINDOW as i32 / 2).min(most).max(0);
            (first - first % BLOCK as i32) as u16
        };
        let [old_x, old_y] = core::mem::replace(&mut self.first, [axis(own.x), axis(own.y)]);
        let [x, y] = self.first;
        if (old_x, old_y) == (x, y) {
            return;
        }
        let stays = |v: u16, old: u16| (old..old + WINDOW as u16).contains(&v);
        let columns = x..x + WINDOW as u16;
        let kept = columns.filter(|&c| stays(c, old_x)).fold(0, |bits, c| bits | 1u32 << (c % WINDOW as u16));
        for r in y..y + WINDOW as u16 {
            if let Some(row) = self.rows.get_mut(usize::from(r) % WINDOW) {
                *row &= if stays(r, old_y) { kept } else { 0 };
            }
        }
    }

    /// Marks what a UAV at `own` (ticks) sees.
    pub(super) fn look(&mut self, own: Vec2) {
        let near = |t: i32| t / CELL - 1..=t / CELL + 1;
        for y in near(own.y) {
            for x in near(own.x) {
                let middle = Vec2 { x: x * CELL + CELL / 2, y: y * CELL + CELL / 2 };
                if (middle - own).within(SEEN_FROM).is_some() {
                    self.mark(x, y);
                }
            }
        }
    }

    fn mark(&mut self, x: i32, y: i32) {
        if !self.is_held(x, y) {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        let Some(row) = self.rows.get_mut(y % WINDOW) else { return };
        let bit = 1u32 << (x % WINDOW);
        if *row & bit == 0 {
            *row |= bit;
            if let Some(ages) = self.ages_of([x / BLOCK % BLOCKS, y / BLOCK % BLOCKS]) {
                ages.changed = Since::NOW;
            }
        }
    }

    fn ages_of(&mut self, [bx, by]: [usize; 2]) -> Option<&mut Ages> {
        self.ages.get_mut(by)?.get_mut(bx)
    }

    /// Whether the window holds a cell, which is of the map then.
    fn is_held(&self, x: i32, y: i32) -> bool {
        let held =
            |v: i32, first: u16| (0..WINDOW as i32).contains(&(v - i32::from(first))) && v < i32::from(self.side);
        held(x, self.first[0]) && held(y, self.first[1])
    }

    /// Whether the cell at a position (ticks) was looked at. Beyond the window nothing was.
    pub(super) fn is_explored(&self, at: Vec2) -> bool {
        let (x, y) = (at.x.div_euclid(CELL), at.y.div_euclid(CELL));
        let row = || self.rows.get(y as usize % WINDOW).copied().unwrap_or(0);
        self.is_held(x, y) && row() >> (x as usize % WINDOW) & 1 == 1
    }

    /// The 16 cells of a block from south-west, row by row; `block` is its place modulo [`BLOCKS`] on each axis.
    fn block(&self, [bx, by]: [usize; 2]) -> u16 {
        let rows = self.rows.iter().skip(by * BLOCK).take(BLOCK);
        rows.enumerate().fold(0, |bits, (k, row)| bits | (row >> (bx * BLOCK) & 0xf) << (k * BLOCK)) as u16
    }

    /// The map's block that is meant by a place modulo [`BLOCKS`], told by a UAV in block `sender`.
    fn told_block(&self, place: usize, sender: i32) -> i32 {
        if usize::from(self.side) <= WINDOW {
            return place as i32;
        }
        let first = sender - TOLD_BLOCKS;
        first + (place as i32 - first).rem_euclid(BLOCKS as i32)
    }

    /// The block to tell next of those not told in this step, as place and cells; it counts as told from now on. `own` is where
    /// the UAV is; its newest neighbour came `newest_neighbour` steps ago. Those come first that have changed since they
    /// were told or that this neighbour was not told, then the nearest.
    pub(super) fn next_to_tell(&mut self, own: Vec2, newest_neighbour: Since) -> Option<(u8, u16)> {
        let own_block = [own.x, own.y].map(|t| t / (CELL * BLOCK as i32));
        let mut best: Option<((bool, i32, usize), [usize; 2])> = None;
        for (by, line) in self.ages.iter().enumerate() {
            for (bx, ages) in line.iter().enumerate() {
                if ages.told == Since::NOW || self.block([bx, by]) == 0 {
                    continue;
                }
                let dx = self.told_block(bx, own_block[0]) - own_block[0];
                let dy = self.told_block(by, own_block[1]) - own_block[1];
                if usize::from(self.side) > WINDOW && (dx > TOLD_BLOCKS || dy > TOLD_BLOCKS) {
                    continue;
                }
                let known = ages.told <= ages.changed.min(newest_neighbour);
                let key = (known, dx * dx + dy * dy, by * BLOCKS + bx);
                if best.is_none_or(|(least, _)| key < least) {
                    best = Some((key, [bx, by]));
                }
            }
        }
        let ((_, _, place), block) = best?;
        if let Some(ages) = self.ages_of(block) {
            ages.told = Since::NOW;
        }
        Some((place as u8, self.block(block)))
    }

    /// Takes in the cells of a block that was told by a UAV at `sender`.
    pub(super) fn insert(&mut self, place: u8, cells: u16, sender: GridPoint) {
        let [bx, by] = [usize::from(place) % BLOCKS, usize::from(place) / BLOCKS];
        if by >= BLOCKS {
            return;
        }
        let at = sender.middle();
        let [x, y] =
            [(bx, at.x), (by, at.y)].map(|(b, t)| self.told_block(b, t / (CELL * BLOCK as i32)) * BLOCK as i32);
        for k in (0..(BLOCK * BLOCK) as i32).filter(|k| cells >> k & 1 == 1) {
            self.mark(x + k % BLOCK as i32, y + k / BLOCK as i32);
        }
    }
}
