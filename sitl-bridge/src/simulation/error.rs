//! Errors of a simulation.

use super::fleet::FleetError;
use crate::connection::OpenError;
use crate::mission::OriginError;
use crate::node::SettingsError;
use covey_env::ScenarioError;
use covey_report::atomic::WriteError;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a simulation ended early.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The scenario's settings contradict each other.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// No map can be laid at the origin.
    #[error(transparent)]
    Origin(#[from] OriginError),
    /// A socket cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The settings of a node are refused.
    #[error(transparent)]
    Node(#[from] SettingsError),
    /// The fleet of simulated autopilots did not start, or it ended.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// The thread of a node ended with an error.
    #[error("the node of UAV {id} ended: {source}")]
    Thread {
        /// The UAV's id.
        id: usize,
        /// Why.
        source: io::Error,
    },
    /// Not all UAVs got into the air in time.
    #[error("not everybody is in the air after {minutes} simulated minutes: {who}")]
    NotAirborne {
        /// How long they were waited for, simulated minutes.
        minutes: i64,
        /// The UAVs that are missing, with the last notice of each.
        who: String,
    },
    /// No UAV started a step for too long.
    #[error("nothing happened for {seconds} s in step {step}: {who}")]
    Stalled {
        /// How long it was waited for, s.
        seconds: u64,
        /// The step of the slowest UAV.
        step: u32,
        /// The UAVs that are behind, with the last notice of each.
        who: String,
    },
    /// A UAV's first step was not step 0.
    #[error("UAV {0} missed the beginning of step 0; is the computer overloaded?")]
    MissedStart(usize),
    /// The mission could not be written beside the recordings.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A recording cannot be made.
    #[error("the recording {} cannot be made: {source}", path.display())]
    Recording {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The autopilots' files have no folder.
    #[error("no folder for the autopilots' files among the temporary ones: {0}")]
    Folder(io::Error),
    /// Real autopilots said nothing that their nodes could use.
    #[error("no autopilot tells the time after {seconds} s: {who}")]
    Silent {
        /// How long they were waited for, s.
        seconds: u64,
        /// The UAVs that are missing, with the last notice of each.
        who: String,
    },
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}
