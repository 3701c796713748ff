//! The vehicle's batteries, kept apart by their ids.

use crate::messages::BatteryStatus;
use std::collections::BTreeMap;

/// What was said of a battery counts for this long, ms of the vehicle's clock. ArduPilot tells of its
/// batteries in turn.
const FRESH_MS: u32 = 10_000;
/// MAV_BATTERY_FUNCTION: unknown, all, propulsion. Avionics and payload have batteries that no flight ends for.
const OF_FLIGHT: [u8; 3] = [0, 1, 2];

/// Remaining charge of the batteries that the vehicle flies by.
#[derive(Clone, Debug, Default)]
pub(super) struct Batteries {
    /// Charge, percent, and when it was told, by battery id.
    of_flight: BTreeMap<u8, (u8, u32)>,
    /// What SYS_STATUS said, of one battery or of all.
    summary: Option<(u8, u32)>,
}

impl Batteries {
    /// Takes in a BATTERY_STATUS. One that does not estimate its charge says nothing.
    pub fn take(&mut self, battery: &BatteryStatus, now_ms: u32) {
        if !OF_FLIGHT.contains(&battery.function) {
            self.of_flight.remove(&battery.id);
        } else if let Some(percent) = battery.percent {
            self.of_flight.insert(battery.id, (percent, now_ms));
        }
    }

    /// Takes in the charge in SYS_STATUS.
    pub fn take_summary(&mut self, percent: Option<u8>, now_ms: u32) {
        self.summary = percent.map(|percent| (percent, now_ms)).or(self.summary);
    }

    /// The lowest charge of a flight battery, percent; where none is known, that in SYS_STATUS.
    pub fn lowest(&self, now_ms: u32) -> Option<u8> {
        let fresh = |&&(_, then): &&(u8, u32)| now_ms.wrapping_sub(then) <= FRESH_MS;
        let lowest = self.of_flight.values().filter(fresh).map(|&(percent, _)| percent).min();
        lowest.or(self.summary.as_ref().filter(fresh).map(|&(percent, _)| percent))
    }
}
