//! Which sender on a link is the vehicle to fly.
//!
//! A port may carry many systems: MAVProxy and mavlink-router put every vehicle, camera and companion
//! computer on each of theirs. A node flies the vehicle with the system id that it was told.

use super::notice::Notice;
use crate::messages::Heartbeat;
use std::collections::BTreeSet;

/// MAV_COMP_ID_AUTOPILOT1.
const AUTOPILOT: u8 = 1;
/// MAV_COMP_ID_ONBOARD_COMPUTER.
const ONBOARD_COMPUTER: u8 = 191;

/// Tells the vehicle to fly from others on its link.
#[derive(Clone, Debug)]
pub(super) struct Identity {
    /// System id of the vehicle to fly.
    vehicle: u8,
    /// System and component that the node sends as.
    own: (u8, u8),
    /// Systems of other autopilots that were heard.
    others: BTreeSet<u8>,
    reported_waiting: bool,
    reported_double: bool,
}

impl Identity {
    pub const fn new(vehicle: u8, own: (u8, u8)) -> Self {
        Self { vehicle, own, others: BTreeSet::new(), reported_waiting: false, reported_double: false }
    }

    /// System that the node sends as.
    pub const fn own_system(&self) -> u8 {
        self.own.0
    }

    /// Whether a HEARTBEAT is that of the autopilot to fly.
    pub const fn is_wanted(&self, from: (u8, u8), heartbeat: &Heartbeat) -> bool {
        from.0 == self.vehicle && is_autopilot(from, heartbeat)
    }

    /// Whether an answer is meant for the node. MAVLink 1 and some autopilots leave the receiver out.
    pub const fn is_for_us(&self, to: (u8, u8)) -> bool {
        (to.0 == 0 || to.0 == self.own.0) && (to.1 == 0 || to.1 == self.own.1)
    }

    /// Which vehicle is waited for; once.
    pub fn waiting(&mut self) -> Option<Notice> {
        let first = !std::mem::replace(&mut self.reported_waiting, true);
        first.then(|| Notice::info(format!("waiting for the autopilot of system {}", self.vehicle)))
    }

    /// A HEARTBEAT of somebody else came. `found` says whether the vehicle to fly is known already.
    pub fn heard_other(&mut self, from: (u8, u8), heartbeat: &Heartbeat, found: bool) -> Option<Notice> {
        if from == self.own {
            let (system, component) = from;
            return self.report_double(format!(
                "another program on this link sends as system {system} and component {component}, as this node does: \
                 is a second node running for this vehicle?"
            ));
        }
        if !is_autopilot(from, heartbeat) || from.0 == self.vehicle || !self.others.insert(from.0) {
            return None;
        }
        if found {
            return (self.others.len() == 1)
                .then(|| Notice::info(format!("system {} on the same link is not listened to", from.0)));
        }
        Some(Notice::warning(self.advice().unwrap_or_default()))
    }

    /// What the operator can do when other vehicles are heard and not the one to fly.
    pub fn advice(&self) -> Option<String> {
        let (vehicle, first) = (self.vehicle, self.others.first()?);
        let heard: Vec<String> = self.others.iter().map(u8::to_string).collect();
        let heard = heard.join(", ");
        Some(format!("heard system {heard}, waiting for system {vehicle}: --vehicle-system {first} flies that one"))
    }

    /// The autopilot answered somebody else's command. Ground stations may command it, a second node must
    /// not.
    pub fn answered_other(&mut self, to: (u8, u8)) -> Option<Notice> {
        if to.1 != ONBOARD_COMPUTER {
            return None;
        }
        self.report_double(format!(
            "the onboard computer of system {} commands this vehicle too: two nodes must not fly one vehicle",
            to.0
        ))
    }

    fn report_double(&mut self, text: String) -> Option<Notice> {
        let first = !std::mem::replace(&mut self.reported_double, true);
        first.then(|| Notice::warning(text))
    }
}

/// Whether a HEARTBEAT comes from the main autopilot of a vehicle: cameras, gimbals, companion
/// computers, ground stations and receivers have other components, types or no autopilot.
const fn is_autopilot((_, component): (u8, u8), heartbeat: &Heartbeat) -> bool {
    let firmware = matches!(heartbeat.autopilot, 3 | 12);
    // MAV_TYPE: antenna tracker, ground station, onboard controller, gimbal, ADS-B receiver, camera, charging
    // station, FLARM, servo, Open Drone ID, battery, parachute, log, OSD, IMU, GPS, winch.
    let device = matches!(heartbeat.kind, 5 | 6 | 18 | 26 | 27 | 30..=34 | 36..=42);
    component == AUTOPILOT && firmware && !device
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heartbeat(autopilot: u8, kind: u8) -> Heartbeat {
        Heartbeat { kind, autopilot, custom_mode: 0, armed: false }
    }

    #[test]
    fn only_the_main_autopilot_of_the_vehicle_is_taken() {
        let identity = Identity::new(7, (8, 191));
        assert!(identity.is_wanted((7, 1), &heartbeat(3, 2)) && identity.is_wanted((7, 1), &heartbeat(12, 13)));
        // Another vehicle; a camera, a companion computer and an ADS-B receiver; no flight stack.
        assert!(!identity.is_wanted((6, 1), &heartbeat(3, 2)));
        assert!(!identity.is_wanted((7, 100), &heartbeat(3, 30)) && !identity.is_wanted((7, 191), &heartbeat(8, 18)));
        assert!(!identity.is_wanted((7, 1), &heartbeat(3, 27)) && !identity.is_wanted((7, 1), &heartbeat(8, 2)));
        assert!(!identity.is_wanted((7, 1), &heartbeat(0, 2)));
    }

    #[test]
    fn answers_are_read_when_addressed_to_the_node_or_to_all() {
        let identity = Identity::new(7, (8, 191));
        assert!([(8, 191), (8, 0), (0, 0)].iter().all(|&to| identity.is_for_us(to)));
        assert!([(8, 190), (255, 190), (7, 191)].iter().all(|&to| !identity.is_for_us(to)));
    }
}
