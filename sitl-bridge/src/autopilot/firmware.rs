//! ArduPilot and PX4: how each numbers its flight modes.

use crate::messages::ParameterValue;
use std::fmt;

/// The autopilot's firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Firmware {
    /// ArduCopter (MAV_AUTOPILOT_ARDUPILOTMEGA).
    ArduPilot,
    /// PX4 (MAV_AUTOPILOT_PX4).
    Px4,
}

/// A flight mode, as far as a node tells them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The mode that follows setpoints: ArduPilot's GUIDED, PX4's OFFBOARD.
    Guided,
    /// PX4's AUTO.TAKEOFF and AUTO.LOITER: what MAV_CMD_NAV_TAKEOFF leads to.
    TakeoffOrHold,
    /// Any other mode, by its `custom_mode`.
    Other(u32),
}

/// Why a vehicle is not supported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnsupportedVehicle {
    /// Neither ArduPilot nor PX4.
    #[error("the autopilot is neither ArduPilot nor PX4 (MAV_AUTOPILOT {0})")]
    Autopilot(u8),
    /// Not a multicopter.
    #[error("the vehicle is no multicopter (MAV_TYPE {0})")]
    Vehicle(u8),
}

impl Firmware {
    /// The firmware that a HEARTBEAT names by its MAV_AUTOPILOT and MAV_TYPE.
    ///
    /// # Errors
    /// See [`UnsupportedVehicle`].
    pub const fn of(autopilot: u8, kind: u8) -> Result<Self, UnsupportedVehicle> {
        let firmware = match autopilot {
            3 => Self::ArduPilot,
            12 => Self::Px4,
            other => return Err(UnsupportedVehicle::Autopilot(other)),
        };
        // Quadrotor, coaxial, helicopter, hexa-, octo-, tri-, dodeca- and decarotor; 0 is generic.
        match kind {
            0 | 2 | 3 | 4 | 13 | 14 | 15 | 29 | 35 => Ok(firmware),
            other => Err(UnsupportedVehicle::Vehicle(other)),
        }
    }

    /// The mode that a HEARTBEAT's `custom_mode` stands for.
    #[must_use]
    pub const fn mode(self, custom_mode: u32) -> Mode {
        match (self, custom_mode) {
            (Self::ArduPilot, 4) => Mode::Guided,
            (Self::Px4, mode) if Px4::of(mode).main == Px4::OFFBOARD => Mode::Guided,
            (Self::Px4, mode) if matches!(Px4::of(mode), Px4 { main: Px4::AUTO, sub: 2 | 3 }) => Mode::TakeoffOrHold,
            (_, mode) => Mode::Other(mode),
        }
    }

    /// The `custom_mode` in heartbeats of a mode that was set by these parameters 2 and 3 of
    /// MAV_CMD_DO_SET_MODE.
    pub(super) const fn custom_mode(self, [main, sub]: [f32; 2]) -> u32 {
        match self {
            Self::ArduPilot => main as u32,
            Self::Px4 => ((sub as u32) << 24) | ((main as u32) << 16),
        }
    }

    /// Whether a `custom_mode` is one of PX4's AUTO modes.
    pub(super) const fn is_automatic(self, custom_mode: u32) -> bool {
        matches!((self, Px4::of(custom_mode)), (Self::Px4, Px4 { main: Px4::AUTO, .. }))
    }

    /// Whether a `custom_mode` is PX4's AUTO.TAKEOFF.
    pub(super) const fn is_taking_off(self, custom_mode: u32) -> bool {
        matches!((self, Px4::of(custom_mode)), (Self::Px4, Px4 { main: Px4::AUTO, sub: 2 }))
    }

    /// Parameters 2 and 3 (mode and submode) of MAV_CMD_DO_SET_MODE for GUIDED or OFFBOARD.
    #[must_use]
    pub const fn guided(self) -> [f32; 2] {
        match self {
            Self::ArduPilot => [4.0, 0.0],
            Self::Px4 => [6.0, 0.0],
        }
    }

    /// Parameters 2 and 3 of MAV_CMD_DO_SET_MODE for the return to launch.
    #[must_use]
    pub const fn return_home(self) -> [f32; 2] {
        match self {
            Self::ArduPilot => [6.0, 0.0],
            Self::Px4 => [4.0, 5.0],
        }
    }

    /// Parameters 2 and 3 of MAV_CMD_DO_SET_MODE for landing at the present position.
    #[must_use]
    pub const fn land(self) -> [f32; 2] {
        match self {
            Self::ArduPilot => [9.0, 0.0],
            Self::Px4 => [4.0, 6.0],
        }
    }

    /// A parameter's value: PX4 sends the bytes of an integer where ArduPilot sends a float.
    pub(super) const fn parameter(self, value: &ParameterValue) -> f64 {
        match self {
            Self::ArduPilot => value.cast(),
            Self::Px4 => value.bytewise(),
        }
    }

    /// The name of the mode that follows setpoints, as users know it.
    #[must_use]
    pub const fn guided_name(self) -> &'static str {
        match self {
            Self::ArduPilot => "GUIDED",
            Self::Px4 => "OFFBOARD",
        }
    }

    /// The name of a mode, as users know it.
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

impl fmt::Display for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArduPilot => "ArduPilot",
            Self::Px4 => "PX4",
        })
    }
}

/// PX4's `custom_mode`: main mode and submode.
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
        assert_eq!(Firmware::ArduPilot.mode(4), Mode::Guided);
        assert_eq!(Firmware::ArduPilot.mode(5), Mode::Other(5));
        assert_eq!(Firmware::Px4.mode(6 << 16), Mode::Guided);
        assert_eq!(Firmware::Px4.mode((3 << 24) | (4 << 16)), Mode::TakeoffOrHold);
        assert_eq!(Firmware::Px4.mode_name((5 << 24) | (4 << 16)), "AUTO.RTL");
        assert_eq!(Firmware::ArduPilot.mode_name(16), "POSHOLD");
        assert_eq!(Firmware::ArduPilot.mode_name(8), "mode 8");
    }

    #[test]
    fn planes_and_strangers_are_refused() {
        assert_eq!(Firmware::of(3, 2), Ok(Firmware::ArduPilot));
        assert_eq!(Firmware::of(12, 13), Ok(Firmware::Px4));
        assert_eq!(Firmware::of(3, 1), Err(UnsupportedVehicle::Vehicle(1)));
        assert_eq!(Firmware::of(8, 6), Err(UnsupportedVehicle::Autopilot(8)));
    }
}
