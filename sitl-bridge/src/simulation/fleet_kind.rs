//! What a simulated swarm flies on.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// The autopilots of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum FleetKind {
    /// Covey's own simulated autopilots, all in one process.
    #[default]
    Simlink,
    /// This program, ArduPilot's Copter built for SITL, once a vehicle.
    ArduCopter(PathBuf),
    /// PX4 from this build folder, with its built-in vehicle, once a vehicle.
    Px4(PathBuf),
}

impl FleetKind {
    /// Its name, as it is written before the path.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Simlink => "simlink",
            Self::ArduCopter(_) => "arducopter",
            Self::Px4(_) => "px4",
        }
    }

    /// Whether real autopilot firmware flies. It has its own clock and knows no lock-step.
    #[must_use]
    pub const fn is_real(&self) -> bool {
        !matches!(self, Self::Simlink)
    }

    /// The user's build.
    pub(super) const fn build(&self) -> Option<&PathBuf> {
        match self {
            Self::Simlink => None,
            Self::ArduCopter(path) | Self::Px4(path) => Some(path),
        }
    }

    /// The Python package that runs it.
    pub(super) const fn package(&self) -> &'static str {
        if self.is_real() { "sitl" } else { "simlink" }
    }
}

impl fmt::Display for FleetKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Simlink => "simlink",
            Self::ArduCopter(_) => "ArduCopter in SITL",
            Self::Px4(_) => "PX4 in SITL",
        })
    }
}

impl FromStr for FleetKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, path) = text.split_once('=').unwrap_or((text, ""));
        match (name, path) {
            ("simlink", "") => Ok(Self::Simlink),
            ("arducopter", "") => {
                Err("arducopter=PROGRAM: the program is missing, ArduPilot's build/sitl/bin/arducopter".into())
            }
            ("arducopter", path) => Ok(Self::ArduCopter(path.into())),
            ("px4", "") => {
                Err("px4=FOLDER: the folder is missing, PX4's build/px4_sitl_default or another with bin/px4".into())
            }
            ("px4", path) => Ok(Self::Px4(path.into())),
            _ => Err("use simlink, arducopter=PROGRAM or px4=FOLDER".into()),
        }
    }
}
