//! How ArduPilot and PX4 name their modes.

use std::fmt;

/// The flight software.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// ArduPilot's Copter.
    ArduPilot,
    /// PX4.
    Px4,
}

/// A flight mode, as far as it matters here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Takes setpoints: ArduPilot's GUIDED, PX4's OFFBOARD.
    Guided,
    /// PX4's takeoff and hold: where a takeoff that we asked for leads.
    TakeoffOrHold,
    /// Any other, by the autopilot's number.
    Other(u32),
}

/// Why a vehicle cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unfit {
    /// Neither ArduPilot nor PX4.
    #[error("the autopilot is neither ArduPilot nor PX4 (MAV_AUTOPILOT {0})")]
    Autopilot(u8),
    /// Not a multicopter.
    #[error("the vehicle is no multicopter (MAV_TYPE {0})")]
    Vehicle(u8),
}

impl Dialect {
    /// By the numbers in a heartbeat.
    ///
    /// # Errors
    /// See [`Unfit`].
    pub const fn of(autopilot: u8, kind: u8) -> Result<Self, Unfit> {
        let dialect = match autopilot {
            3 => Self::ArduPilot,
            12 => Self::Px4,
            other => return Err(Unfit::Autopilot(other)),
        };
        // Quadrotor, coaxial, helicopter, hexa-, octo-, tri-, dodeca- and decarotor; 0 is generic.
        match kind {
            0 | 2 | 3 | 4 | 13 | 14 | 15 | 29 | 35 => Ok(dialect),
            other => Err(Unfit::Vehicle(other)),
        }
    }

    /// The mode that a heartbeat's number means.
    #[must_use]
    pub const fn mode(self, custom_mode: u32) -> Mode {
        match (self, custom_mode) {
            (Self::ArduPilot, 4) => Mode::Guided,
            (Self::Px4, mode) if Px4::of(mode).main == Px4::OFFBOARD => Mode::Guided,
            (Self::Px4, mode) if matches!(Px4::of(mode), Px4 { main: Px4::AUTO, sub: 2 | 3 }) => Mode::TakeoffOrHold,
            (_, mode) => Mode::Other(mode),
        }
    }

    /// Parameters 2 and 3 of DO_SET_MODE for GUIDED or OFFBOARD.
    #[must_use]
    pub const fn guided(self) -> [f32; 2] {
        match self {
            Self::ArduPilot => [4.0, 0.0],
            Self::Px4 => [6.0, 0.0],
        }
    }

    /// The same for the return home.
    #[must_use]
    pub const fn return_home(self) -> [f32; 2] {
        match self {
            Self::ArduPilot => [6.0, 0.0],
            Self::Px4 => [4.0, 5.0],
        }
    }

    /// The same for landing on the spot.
    #[must_use]
    pub const fn land(self) -> [f32; 2] {
        match self {
            Self::ArduPilot => [9.0, 0.0],
            Self::Px4 => [4.0, 6.0],
        }
    }

    /// What users know the mode that takes setpoints by.
    #[must_use]
    pub const fn guided_name(self) -> &'static str {
        match self {
            Self::ArduPilot => "GUIDED",
            Self::Px4 => "OFFBOARD",
        }
    }

    /// The mode in the users' words.
    #[must_use]
    pub fn mode_name(self, custom_mode: u32) -> String {
        let known = match self {
            Self::ArduPilot => {
                const NAMES: [&str; 22] = [
                    "STABILIZE",
                    "ACRO",
                    "ALT_HOLD",
                    "AUTO",
                    "GUIDED",
                    "LOITER",
                    "RTL",
                    "CIRCLE",
                    "",
                    "LAND",
                    "",
                    "DRIFT",
                    "",
                    "SPORT",
                    "FLIP",
                    "AUTOTUNE",
                    "POSHOLD",
                    "BRAKE",
                    "THROW",
                    "AVOID_ADSB",
                    "GUIDED_NOGPS",
                    "SMART_RTL",
                ];
                usize::try_from(custom_mode).ok().and_then(|i| NAMES.get(i)).copied()
            }
            Self::Px4 => match Px4::of(custom_mode) {
                Px4 { main: 1, .. } => Some("MANUAL"),
                Px4 { main: 2, .. } => Some("ALTCTL"),
                Px4 { main: 3, .. } => Some("POSCTL"),
                Px4 { main: Px4::AUTO, sub } => {
                    const NAMES: [&str; 7] =
                        ["AUTO", "READY", "AUTO.TAKEOFF", "AUTO.LOITER", "AUTO.MISSION", "AUTO.RTL", "AUTO.LAND"];
                    NAMES.get(usize::from(sub)).copied()
                }
                Px4 { main: Px4::OFFBOARD, .. } => Some("OFFBOARD"),
                Px4 { main: 7, .. } => Some("STABILIZED"),
                _ => None,
            },
        };
        known.filter(|name| !name.is_empty()).map_or_else(|| format!("mode {custom_mode}"), Into::into)
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArduPilot => "ArduPilot",
            Self::Px4 => "PX4",
        })
    }
}

/// PX4 packs two numbers into one.
struct Px4 {
    main: u8,
    sub: u8,
}

impl Px4 {
    const AUTO: u8 = 4;
    const OFFBOARD: u8 = 6;

    const fn of(custom_mode: u32) -> Self {
        let [_, _, main, sub] = custom_mode.to_le_bytes();
        Self { main, sub }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_by_their_numbers() {
        assert_eq!(Dialect::ArduPilot.mode(4), Mode::Guided);
        assert_eq!(Dialect::ArduPilot.mode(5), Mode::Other(5));
        assert_eq!(Dialect::Px4.mode(6 << 16), Mode::Guided);
        assert_eq!(Dialect::Px4.mode((3 << 24) | (4 << 16)), Mode::TakeoffOrHold);
        assert_eq!(Dialect::Px4.mode_name((5 << 24) | (4 << 16)), "AUTO.RTL");
        assert_eq!(Dialect::ArduPilot.mode_name(16), "POSHOLD");
        assert_eq!(Dialect::ArduPilot.mode_name(8), "mode 8");
    }

    #[test]
    fn planes_and_strangers_are_refused() {
        assert_eq!(Dialect::of(3, 2), Ok(Dialect::ArduPilot));
        assert_eq!(Dialect::of(12, 13), Ok(Dialect::Px4));
        assert_eq!(Dialect::of(3, 1), Err(Unfit::Vehicle(1)));
        assert_eq!(Dialect::of(8, 6), Err(Unfit::Autopilot(8)));
    }
}
