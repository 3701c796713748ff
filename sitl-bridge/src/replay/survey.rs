//! Who is who in a recording.

use super::Foreign;
use crate::frame::Frame;
use crate::swarm_link::{COMPONENT, MESSAGE_TYPE, system_of};
use crate::tlog::{Flight, NOTE_COMPONENT, Note, NoteReader, Record, TlogReader};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};
use thiserror::Error;

const HEARTBEAT: u32 = 0;
const COMMAND_LONG: u32 = 76;
pub(super) const SETPOINT: u32 = 84;
const V2_EXTENSION: u32 = 248;
/// Commands by which a node brings its vehicle into flight: take-off and arming.
const BRING_UP: [u16; 2] = [22, 400];

/// The year 2200, microseconds since 1970.
const LATEST_US: u64 = 7_258_118_400_000_000;
/// So many records at one time have none.
const TIMELESS: u64 = 100;

/// Why a recording cannot be replayed.
#[derive(Debug, Error)]
pub enum SurveyError {
    /// It cannot be read.
    #[error("it cannot be read")]
    Read(#[from] io::Error),
    /// It is no tlog.
    #[error("{}", in_words(*.0))]
    Foreign(Foreign),
    /// Its times are none.
    #[error(
        "its records have no times that make sense ({0}): a replay needs the microseconds since 1970 at which each frame was \
         sent or heard. Record with `fly --tlog` or `swarm --tlog`"
    )]
    Times(&'static str),
    /// Two recordings are in one file.
    #[error(
        "{flights} flights of the node are in it, one behind the other: cut it apart where the notes `covey flight` are"
    )]
    SeveralFlights {
        /// How many.
        flights: u64,
    },
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
    Told,
    /// A neighbour's message.
    Swarm,
    /// A frame that came from the autopilot's link.
    Autopilot,
    /// A piece of a note of the recording itself.
    Note,
}

fn in_words(foreign: Foreign) -> String {
    match foreign {
        Foreign::Stream => {
            "it is a stream of MAVLink frames without times, as it was on the wire (MAVProxy's `.tlog.raw` is \
                            one): a replay needs to know when each frame came. Take the `.tlog`, as `fly --tlog` or \
                            `swarm --tlog` records it"
                .into()
        }
        Foreign::Other(kind) => format!("it is {kind} and no tlog, as `fly --tlog` or `swarm --tlog` records it"),
    }
}

/// Who is who in a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Survey {
    /// The UAV.
    pub id: u16,
    /// The node's MAVLink system towards the autopilot.
    pub system: u8,
    /// Whether the node brought its vehicle into flight.
    pub took_off: bool,
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

/// Notes of one node.
#[derive(Debug, Default)]
struct Notes {
    reader: NoteReader,
    flights: u64,
    flight: Option<Flight>,
    epoch_ms: Option<i64>,
}

/// Times met in a log.
#[derive(Debug, Default)]
struct Times {
    records: u64,
    same: u64,
    late: u64,
    last_us: Option<u64>,
}

impl Times {
    fn take(&mut self, unix_us: u64) {
        self.records += 1;
        self.same += u64::from(self.last_us == Some(unix_us));
        self.late += u64::from(unix_us > LATEST_US);
        self.last_us = Some(unix_us);
    }

    fn check(&self) -> Result<(), SurveyError> {
        // One damaged time among many is borne.
        if self.late * 2 > self.records {
            return Err(SurveyError::Times("they lie beyond the year 2200: is the lowest byte first?"));
        }
        if self.records >= TIMELESS && self.same + 1 == self.records {
            return Err(SurveyError::Times("they are all the same"));
        }
        Ok(())
    }
}

impl Survey {
    /// Reads a log to its end. Of the UAV's id and the node's system, those that are not named
    /// are found out where the log leaves no doubt.
    ///
    /// # Errors
    /// See [`SurveyError`].
    pub fn of<R: Read>(log: &mut TlogReader<R>, id: Option<u16>, system: Option<u8>) -> Result<Self, SurveyError> {
        let (mut nodes, mut ids) = (BTreeSet::new(), BTreeSet::new());
        let (mut records, mut bytes) = (0, 0);
        let mut brought_up = BTreeSet::new();
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
                if frame.message_id() == SETPOINT {
                    nodes.insert(frame.system());
                } else if frame.message_id() == COMMAND_LONG && command(&frame).is_some_and(|c| BRING_UP.contains(&c)) {
                    brought_up.insert(frame.system());
                }
            }
        }
        if records == 0 {
            return Err(SurveyError::NoFrames { bytes: bytes + log.skipped() });
        }
        times.check()?;
        nodes.retain(|&node| system.is_none_or(|s| s == node));
        let system = match (nodes.first(), nodes.len()) {
            (Some(&only), 1) => only,
            (None, _) => return Err(SurveyError::NoSetpoints { records, system }),
            _ => match id.and_then(system_of).filter(|s| nodes.contains(s)) {
                Some(own) => own,
                None => return Err(SurveyError::SeveralNodes { systems: nodes.into_iter().collect() }),
            },
        };
        let Notes { flight, epoch_ms, flights, .. } = notes.remove(&system).unwrap_or_default();
        if flights > 1 {
            return Err(SurveyError::SeveralFlights { flights });
        }
        let ids: Vec<u16> = ids.into_iter().collect();
        let noted = flight.as_ref().and_then(|flight| flight.number::<u16>("id"));
        let id = match (id, noted.or(system.checked_sub(1).map(u16::from))) {
            (Some(id), _) if noted.is_some_and(|noted| noted != id) => {
                let ids = if ids.is_empty() { noted.into_iter().collect() } else { ids };
                return Err(SurveyError::OtherUav { id, ids });
            }
            (Some(id), _) if ids.is_empty() || ids.contains(&id) => id,
            (Some(id), _) => return Err(SurveyError::OtherUav { id, ids }),
            (None, Some(id)) if noted.is_some() => id,
            (None, Some(id)) if ids.is_empty() || ids.contains(&id) => id,
            (None, _) => return Err(SurveyError::WhichId { system, ids }),
        };
        let noted = flight.as_ref().and_then(|flight| flight.number::<u8>("take_off"));
        let took_off = noted.map_or_else(|| brought_up.contains(&system), |noted| noted != 0);
        let (skipped, cut) = (log.skipped(), log.is_cut());
        Ok(Self { id, system, took_off, records, skipped, cut, flight, epoch_ms })
    }

    /// What a frame was to the node. A neighbour message that an autopilot had passed on looks
    /// like one from the swarm; the neighbour table takes each only once.
    #[must_use]
    pub fn role(&self, frame: &Frame) -> Role {
        if Note::is_piece(frame, self.system) {
            return Role::Note;
        }
        if is_neighbour(frame) {
            return if Some(frame.system()) == system_of(self.id) { Role::Told } else { Role::Swarm };
        }
        if frame.system() == self.system && frame.component() == COMPONENT {
            match frame.message_id() {
                SETPOINT => return Role::Setpoint,
                HEARTBEAT | COMMAND_LONG => return Role::Sent,
                _ => {}
            }
        }
        Role::Autopilot
    }
}

impl Notes {
    fn take(&mut self, frame: &Frame) {
        match self.reader.take(frame) {
            Some(Note::Flight(flight)) => {
                self.flights += 1;
                self.flight = Some(flight);
            }
            Some(Note::Epoch(epoch_ms)) => self.epoch_ms = epoch_ms,
            Some(Note::Order(_)) | None => {}
        }
    }
}

fn is_neighbour(frame: &Frame) -> bool {
    frame.message_id() == V2_EXTENSION && frame.payload().get(..2) == Some(&MESSAGE_TYPE.to_le_bytes())
}

/// COMMAND_LONG's command.
fn command(frame: &Frame) -> Option<u16> {
    Some(u16::from_le_bytes(*frame.payload().get(28..30)?.first_chunk()?))
}
