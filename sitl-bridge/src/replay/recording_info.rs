//! Who is who in a recording.

use crate::frame::Frame;
use crate::messages::{CommandLong, SetPositionTargetLocalNed, id, mav_cmd};
use crate::swarm_link::{COMPONENT, is_neighbour, system_of};
use crate::tlog::{Record, TlogReader};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};
use thiserror::Error;

/// Commands by which a node brings its vehicle into flight: take-off and arming.
const BRING_UP: [u16; 2] = [mav_cmd::NAV_TAKEOFF, mav_cmd::COMPONENT_ARM_DISARM];

/// Why a recording cannot be replayed.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// It cannot be read.
    #[error("it cannot be read")]
    Read(#[from] io::Error),
    /// There is no frame in it.
    #[error(
        "there is no MAVLink frame in its {bytes} bytes. A tlog comes from `sitl-bridge fly --tlog`, MAVProxy, Mission \
         Planner or QGroundControl"
    )]
    NoFrames {
        /// Bytes in it.
        bytes: u64,
    },
    /// There is no setpoint of a node in it.
    #[error(
        "none of its {records} frames is a setpoint of a node{}. A recording of the flight itself is needed, by `fly \
         --tlog` or `swarm --tlog`, and the flight must have got into the air",
        system.map(|s| format!(" with MAVLink system {s}")).unwrap_or_default()
    )]
    NoSetpoints {
        /// Frames in it.
        records: u64,
        /// The node's system, where it was named.
        system: Option<u8>,
    },
    /// Several nodes sent setpoints.
    #[error("setpoints of the MAVLink systems {systems:?} are in it: name the node's with --system")]
    SeveralNodes {
        /// Their systems.
        systems: Vec<u8>,
    },
    /// The id cannot be told.
    #[error(
        "the node has MAVLink system {system}, from which its id cannot be told: name it with --id (UAVs heard or \
         flown: {})",
        ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    )]
    WhichId {
        /// The node's system.
        system: u8,
        /// Ids that neighbour messages in the log have.
        ids: Vec<u16>,
    },
    /// It is of another UAV.
    #[error("it has no neighbour message of UAV {id}, but of {ids:?}: is it another UAV's recording?")]
    OtherUav {
        /// The id that was named.
        id: u16,
        /// Ids that neighbour messages in the log have.
        ids: Vec<u16>,
    },
}

/// What a frame in the log was to the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A setpoint that it sent.
    Setpoint,
    /// Another frame that it sent to the autopilot.
    Sent,
    /// A message that it told the swarm.
    Broadcast,
    /// A neighbour's message.
    Swarm,
    /// A frame that came from the autopilot's link.
    Autopilot,
}

/// Who is who in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordingInfo {
    /// The UAV.
    pub id: u16,
    /// The node's MAVLink system towards the autopilot.
    pub system: u8,
    /// MAVLink system of the vehicle that it flew.
    pub vehicle: u8,
    /// Whether the node brought its vehicle into flight.
    pub took_off: bool,
    /// Frames in the log.
    pub records: u64,
    /// Bytes that belong to no record.
    pub skipped: u64,
    /// Whether the log ends in the middle of a record.
    pub cut: bool,
}

impl RecordingInfo {
    /// Reads a log to its end. Of the UAV's id and the node's system, those that are not named
    /// are found out where the log leaves no doubt.
    ///
    /// # Errors
    /// See [`RecordingError`].
    pub fn of<R: Read>(log: &mut TlogReader<R>, id: Option<u16>, system: Option<u8>) -> Result<Self, RecordingError> {
        let (mut nodes, mut ids) = (BTreeSet::new(), BTreeSet::new());
        // The vehicle that each node first addressed.
        let mut vehicles = BTreeMap::new();
        let (mut records, mut bytes) = (0, 0);
        let mut brought_up = BTreeSet::new();
        for record in &mut *log {
            let Record { frame, .. } = record?;
            records += 1;
            bytes += 8 + frame.bytes().len() as u64;
            if is_neighbour(&frame) {
                ids.extend(frame.system().checked_sub(1).map(u16::from));
            } else if frame.component() == COMPONENT {
                let to = match frame.message_id() {
                    id::SET_POSITION_TARGET_LOCAL_NED => {
                        nodes.insert(frame.system());
                        SetPositionTargetLocalNed::target_system(frame.payload())
                    }
                    id::COMMAND_LONG => {
                        if BRING_UP.contains(&CommandLong::read(frame.payload()).command) {
                            brought_up.insert(frame.system());
                        }
                        CommandLong::target_system(frame.payload())
                    }
                    _ => continue,
                };
                vehicles.entry(frame.system()).or_insert(to);
            }
        }
        if records == 0 {
            return Err(RecordingError::NoFrames { bytes: bytes + log.skipped() });
        }
        nodes.retain(|&node| system.is_none_or(|s| s == node));
        let system = match (nodes.first(), nodes.len()) {
            (Some(&only), 1) => only,
            (None, _) => return Err(RecordingError::NoSetpoints { records, system }),
            _ => match id.and_then(system_of).filter(|s| nodes.contains(s)) {
                Some(own) => own,
                None => return Err(RecordingError::SeveralNodes { systems: nodes.into_iter().collect() }),
            },
        };
        let ids: Vec<u16> = ids.into_iter().collect();
        let id = match (id, system.checked_sub(1).map(u16::from)) {
            (Some(id), _) if ids.is_empty() || ids.contains(&id) => id,
            (Some(id), _) => return Err(RecordingError::OtherUav { id, ids }),
            (None, Some(id)) if ids.is_empty() || ids.contains(&id) => id,
            (None, _) => return Err(RecordingError::WhichId { system, ids }),
        };
        let took_off = brought_up.contains(&system);
        let vehicle = vehicles.get(&system).copied().unwrap_or(system);
        Ok(Self { id, system, vehicle, took_off, records, skipped: log.skipped(), cut: log.is_cut() })
    }

    /// What a frame was to the node. A neighbour message that an autopilot had passed on looks
    /// like one from the swarm; the neighbour table takes each only once.
    #[must_use]
    pub fn role(&self, frame: &Frame) -> Role {
        if is_neighbour(frame) {
            return if Some(frame.system()) == system_of(self.id) { Role::Broadcast } else { Role::Swarm };
        }
        if frame.system() == self.system && frame.component() == COMPONENT {
            match frame.message_id() {
                id::SET_POSITION_TARGET_LOCAL_NED => return Role::Setpoint,
                id::HEARTBEAT | id::COMMAND_LONG => return Role::Sent,
                _ => {}
            }
        }
        Role::Autopilot
    }
}
