//! Why a recording cannot be replayed.

use super::stream::Foreign;
use std::io;
use thiserror::Error;

/// Why a recording cannot be replayed.
#[derive(Debug, Error)]
pub enum RecordingError {
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
