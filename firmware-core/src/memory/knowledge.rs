//! What a UAV passes on in a step, as bytes.

use super::point::{GridPoint, POI_BITS, TARGET_BITS, in_window, is_in_window};
use super::reports::Report;
use heapless::Vec;

/// Most bytes of knowledge in a message.
pub const MAX_KNOWLEDGE: usize = 200;
/// Length of a PoI, bytes: x (9 bits) and y (9 bits) in half units, age (6 bits) in two steps.
pub const POI_LEN: usize = 3;
/// Length of a report, bytes: id (14 bits), target x and y (8 bits each) in units, arrival and age (5 bits each).
pub const REPORT_LEN: usize = 5;
/// Length of a block of explored area, bytes: place (6 bits), cells (16 bits), two zeros.
pub const BLOCK_LEN: usize = 3;
/// Greatest id that a report can name.
pub const MAX_REPORT_ID: u16 = (1 << 14) - 1;

/// Where a sender is and how large the map is, in grid squares: what coordinates in its knowledge are told against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) sender: GridPoint,
    pub(super) side: u32,
}

/// PoIs, reports and blocks of explored area in the form in which they travel (`docs/memory.md`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Knowledge {
    pois: u8,
    reports: u8,
    blocks: u8,
    bytes: Vec<u8, MAX_KNOWLEDGE>,
}

impl Knowledge {
    /// Nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { pois: 0, reports: 0, blocks: 0, bytes: Vec::new() }
    }

    /// From a message: these numbers of PoIs, reports and blocks, and their bytes. `None` when the length does not fit
    /// the numbers or is above [`MAX_KNOWLEDGE`].
    #[must_use]
    pub fn from_bytes([pois, reports, blocks]: [u8; 3], bytes: &[u8]) -> Option<Self> {
        let len = usize::from(pois) * POI_LEN + usize::from(reports) * REPORT_LEN + usize::from(blocks) * BLOCK_LEN;
        if len != bytes.len() {
            return None;
        }
        Some(Self { pois, reports, blocks, bytes: Vec::from_slice(bytes).ok()? })
    }

    /// Numbers of PoIs, reports and blocks.
    #[must_use]
    pub const fn counts(&self) -> [u8; 3] {
        [self.pois, self.reports, self.blocks]
    }

    /// Their bytes, in this order.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Nothing, in place.
    pub(super) fn clear(&mut self) {
        *self = Self::new();
    }

    /// Adds a PoI, unless it lies outside of the window. PoIs come before everything else.
    pub(super) fn add_poi(&mut self, frame: Frame, at: GridPoint, age: u8) {
        let tellable = is_in_window::<POI_BITS>(at.x, frame.sender.x, frame.side)
            && is_in_window::<POI_BITS>(at.y, frame.sender.y, frame.side);
        let mask = (1 << POI_BITS) - 1;
        // Never younger than it is.
        let age = u32::from(age).div_ceil(2).min(63);
        let record = (u32::from(at.x) & mask) | (u32::from(at.y) & mask) << 9 | age << 18;
        let added = tellable && self.bytes.extend_from_slice(&record.to_le_bytes()[..POI_LEN]).is_ok();
        self.pois += u8::from(added);
    }

    /// Adds a report behind the PoIs, unless its target lies outside of the window or its id is above [`MAX_REPORT_ID`].
    pub(super) fn add_report(&mut self, frame: Frame, report: &Report) {
        let (x, y) = (report.target.x / 2, report.target.y / 2);
        let tellable = is_in_window::<TARGET_BITS>(x, frame.sender.x / 2, frame.side / 2)
            && is_in_window::<TARGET_BITS>(y, frame.sender.y / 2, frame.side / 2)
            && report.id <= MAX_REPORT_ID;
        let record = u64::from(report.id)
            | (u64::from(x) & 0xff) << 14
            | (u64::from(y) & 0xff) << 22
            | u64::from(report.arrival & 31) << 30
            | u64::from(report.age & 31) << 35;
        let added = tellable && self.bytes.extend_from_slice(&record.to_le_bytes()[..REPORT_LEN]).is_ok();
        self.reports += u8::from(added);
    }

    /// Adds a block behind the reports.
    pub(super) fn add_block(&mut self, place: u8, cells: u16) {
        let record = u32::from(place & 63) | u32::from(cells) << 6;
        let added = self.bytes.extend_from_slice(&record.to_le_bytes()[..BLOCK_LEN]).is_ok();
        self.blocks += u8::from(added);
    }

    /// The PoIs that lie on the map, with the steps since they were seen.
    pub(super) fn pois(&self, frame: Frame) -> impl Iterator<Item = (GridPoint, u8)> {
        let records = self.bytes.chunks_exact(POI_LEN).take(usize::from(self.pois));
        let pois = records.map(move |r| {
            let bits = number(r) as u32;
            let mask = (1 << POI_BITS) - 1;
            let x = in_window::<POI_BITS>(bits & mask, frame.sender.x, frame.side);
            let y = in_window::<POI_BITS>(bits >> 9 & mask, frame.sender.y, frame.side);
            (GridPoint { x, y }, 2 * (bits >> 18 & 63) as u8)
        });
        pois.filter(move |(at, _)| at.is_on_map(frame.side))
    }

    /// The reports whose target lies on the map.
    pub(super) fn reports(&self, frame: Frame) -> impl Iterator<Item = Report> {
        let all = self.bytes.get(usize::from(self.pois) * POI_LEN..).unwrap_or_default();
        let reports = all.chunks_exact(REPORT_LEN).take(usize::from(self.reports)).map(move |r| {
            let bits = number(r);
            let axis = |shift: u32, sender: u16| {
                let v = in_window::<TARGET_BITS>((bits >> shift) as u32 & 0xff, sender / 2, frame.side / 2);
                v.saturating_mul(2).saturating_add(1)
            };
            let target = GridPoint { x: axis(14, frame.sender.x), y: axis(22, frame.sender.y) };
            Report::new((bits & 0x3fff) as u16, target, (bits >> 30 & 31) as u8, (bits >> 35 & 31) as u8)
        });
        reports.filter(move |r| r.target.is_on_map(frame.side))
    }

    /// The blocks as place and cells.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (u8, u16)> {
        let before = usize::from(self.pois) * POI_LEN + usize::from(self.reports) * REPORT_LEN;
        let all = self.bytes.get(before..).unwrap_or_default();
        all.chunks_exact(BLOCK_LEN).take(usize::from(self.blocks)).map(|r| {
            let bits = number(r);
            ((bits & 63) as u8, (bits >> 6) as u16)
        })
    }
}

/// Up to eight bytes as a little-endian number.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b))
}
