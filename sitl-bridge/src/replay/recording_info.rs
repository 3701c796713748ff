//! Who is who in a recording.

use super::error::RecordingError;
use super::notes::Notes;
use super::times::Times;
use crate::frame::Frame;
use crate::messages::{CommandLong, SetPositionTargetLocalNed, id, mav_cmd};
use crate::swarm_link::{COMPONENT, is_neighbour, system_of};
use crate::tlog::{Flight, NOTE_COMPONENT, Note, Record, TlogReader};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

/// Commands by which a node brings its vehicle into flight: take-off and arming.
const BRING_UP: [u16; 2] = [mav_cmd::NAV_TAKEOFF, mav_cmd::COMPONENT_ARM_DISARM];

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
    /// A piece of a note of the recording itself.
    Note,
}

/// Who is who in a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingInfo {
    /// The UAV.
    pub id: u16,
    /// The node's MAVLink system towards the autopilot.
    pub system: u8,
    /// MAVLink system of the vehicle that it flew.
    pub vehicle: u8,
    /// Whether the node brought its vehicle into flight.
    pub took_off: bool,
    /// Messages that the node requested: those of earlier versions asked for fewer.
    pub requested: BTreeSet<u32>,
    /// Frames in the log.
    pub records: u64,
    /// Bytes that belong to no record.
    pub skipped: u64,
    /// Whether the log ends in the middle of a record.
    pub cut: bool,
    /// The node's settings, where they are in it.
    pub flight: Option<Flight>,
    /// From which Unix time (ms) steps were counted in the end, where that is in it.
    pub epoch_ms: Option<i64>,
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
        let mut requested: BTreeMap<u8, BTreeSet<u32>> = BTreeMap::new();
        let mut notes: BTreeMap<u8, Notes> = BTreeMap::new();
        let mut times = Times::default();
        for record in &mut *log {
            let Record { frame, unix_us } = record?;
            records += 1;
            times.take(unix_us);
            bytes += 8 + frame.bytes().len() as u64;
            if frame.component() == NOTE_COMPONENT && Note::is_piece(&frame, frame.system()) {
                notes.entry(frame.system()).or_default().take(&frame);
            } else if is_neighbour(&frame) {
                ids.extend(frame.system().checked_sub(1).map(u16::from));
            } else if frame.component() == COMPONENT {
                let to = match frame.message_id() {
                    id::SET_POSITION_TARGET_LOCAL_NED => {
                        nodes.insert(frame.system());
                        SetPositionTargetLocalNed::target_system(frame.payload())
                    }
                    id::COMMAND_LONG => {
                        let command = CommandLong::read(frame.payload());
                        if BRING_UP.contains(&command.command) {
                            brought_up.insert(frame.system());
                        }
                        requested.entry(frame.system()).or_default().extend(command.requested_message());
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
        times.check()?;
        nodes.retain(|&node| system.is_none_or(|s| s == node));
        let system = match (nodes.first(), nodes.len()) {
            (Some(&only), 1) => only,
            (None, _) => return Err(RecordingError::NoSetpoints { records, system }),
            _ => match id.and_then(system_of).filter(|s| nodes.contains(s)) {
                Some(own) => own,
                None => return Err(RecordingError::SeveralNodes { systems: nodes.into_iter().collect() }),
            },
        };
        let Notes { flight, epoch_ms, flights, .. } = notes.remove(&system).unwrap_or_default();
        if flights > 1 {
            return Err(RecordingError::SeveralFlights { flights });
        }
        let ids: Vec<u16> = ids.into_iter().collect();
        let noted = flight.as_ref().and_then(|flight| flight.number::<u16>("id"));
        let id = match (id, noted.or(system.checked_sub(1).map(u16::from))) {
            (Some(id), _) if noted.is_some_and(|noted| noted != id) => {
                let ids = if ids.is_empty() { noted.into_iter().collect() } else { ids };
                return Err(RecordingError::OtherUav { id, ids });
            }
            (Some(id), _) if ids.is_empty() || ids.contains(&id) => id,
            (Some(id), _) => return Err(RecordingError::OtherUav { id, ids }),
            (None, Some(id)) if noted.is_some() => id,
            (None, Some(id)) if ids.is_empty() || ids.contains(&id) => id,
            (None, _) => return Err(RecordingError::WhichId { system, ids }),
        };
        let noted = flight.as_ref().and_then(|flight| flight.number::<u8>("take_off"));
        let took_off = noted.map_or_else(|| brought_up.contains(&system), |noted| noted != 0);
        let vehicle = vehicles.get(&system).copied().unwrap_or(system);
        let (skipped, cut) = (log.skipped(), log.is_cut());
        let requested = requested.remove(&system).unwrap_or_default();
        Ok(Self { id, system, vehicle, took_off, requested, records, skipped, cut, flight, epoch_ms })
    }

    /// What a frame was to the node. A neighbour message that an autopilot had passed on looks
    /// like one from the swarm; the neighbour table takes each only once.
    #[must_use]
    pub fn role(&self, frame: &Frame) -> Role {
        if Note::is_piece(frame, self.system) {
            return Role::Note;
        }
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
