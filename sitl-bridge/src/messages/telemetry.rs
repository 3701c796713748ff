//! The messages that a node reads from an autopilot.

use super::fields::Fields;
use super::id;
use super::parameter::ParameterValue;

/// A decoded message of the autopilot; messages that no decision depends on have no variant.
#[derive(Clone, Debug, PartialEq)]
pub enum Telemetry {
    /// HEARTBEAT (0).
    Heartbeat(Heartbeat),
    /// SYS_STATUS (1): remaining charge, percent; `None` when the autopilot does not estimate it.
    Charge(Option<u8>),
    /// BATTERY_STATUS (147): one of the batteries.
    Battery(BatteryStatus),
    /// SYSTEM_TIME (2).
    SystemTime {
        /// `time_unix_usec`: Unix time, µs; 0 until the autopilot has it from GPS.
        unix_us: u64,
        /// `time_boot_ms`: time since boot.
        boot_ms: u32,
    },
    /// PARAM_VALUE (22).
    Parameter(ParameterValue),
    /// GPS_RAW_INT (24).
    Gps {
        /// GPS_FIX_TYPE; 3 (a 3D fix) and above are good enough to fly.
        fix: u8,
        /// Altitude above mean sea level by the GPS alone, mm; `None` where it is left at zero.
        alt_mm: Option<i32>,
    },
    /// LOCAL_POSITION_NED (32).
    Local(LocalPosition),
    /// GLOBAL_POSITION_INT (33).
    Global(GlobalPosition),
    /// GPS_GLOBAL_ORIGIN (49): the origin of the estimator's local frame.
    Origin {
        /// Latitude, 1e-7 degrees.
        lat_e7: i32,
        /// Longitude, 1e-7 degrees.
        lon_e7: i32,
    },
    /// COMMAND_ACK (77).
    Ack {
        /// The acknowledged MAV_CMD.
        command: u16,
        /// MAV_RESULT.
        result: u8,
        /// System and component whose command it was; 0 where the autopilot does not say.
        to: (u8, u8),
    },
    /// EKF_STATUS_REPORT (193) or ESTIMATOR_STATUS (230).
    Estimator {
        /// Whether the estimator provides attitude, velocity and absolute position, height among them, and
        /// reports no fault.
        healthy: bool,
    },
    /// EXTENDED_SYS_STATE (245): whether the vehicle is landed; `None` when it does not know.
    OnGround(Option<bool>),
    /// STATUSTEXT (253).
    Text {
        /// MAV_SEVERITY: 0 (emergency) to 7 (debug).
        severity: u8,
        /// The text, without control characters.
        text: String,
    },
}

/// HEARTBEAT (0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heartbeat {
    /// MAV_TYPE.
    pub kind: u8,
    /// MAV_AUTOPILOT; 8 (MAV_AUTOPILOT_INVALID) is a ground station or a companion computer.
    pub autopilot: u8,
    /// `custom_mode`: the flight mode, numbered by the autopilot's firmware.
    pub custom_mode: u32,
    /// MAV_MODE_FLAG_SAFETY_ARMED: the motors may turn.
    pub armed: bool,
}

/// BATTERY_STATUS (147).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatteryStatus {
    /// The battery's id.
    pub id: u8,
    /// MAV_BATTERY_FUNCTION: what it powers.
    pub function: u8,
    /// Remaining charge, percent; `None` when the autopilot does not estimate it.
    pub percent: Option<u8>,
}

/// LOCAL_POSITION_NED (32), in the local frame of the estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalPosition {
    /// `time_boot_ms`: time since boot.
    pub boot_ms: u32,
    /// Position north, east and down of the estimator's origin, m.
    pub position_m: [f32; 3],
    /// Velocity north, east and down, m/s.
    pub velocity_mps: [f32; 3],
}

impl LocalPosition {
    /// Whether no number is NaN or infinite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.position_m.iter().chain(&self.velocity_mps).all(|v| v.is_finite())
    }
}

/// GLOBAL_POSITION_INT (33).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlobalPosition {
    /// `time_boot_ms`: time since boot.
    pub boot_ms: u32,
    /// Latitude, 1e-7 degrees.
    pub lat_e7: i32,
    /// Longitude, 1e-7 degrees.
    pub lon_e7: i32,
    /// Altitude above mean sea level, mm.
    pub alt_mm: i32,
    /// Altitude above home, mm.
    pub relative_mm: i32,
    /// Velocity north, east and down, cm/s.
    pub velocity_cmps: [i16; 3],
}

impl Telemetry {
    /// Decodes a payload in the order of the wire, where zeros at the end may be missing; `None` for
    /// messages that have no variant.
    #[must_use]
    pub fn read(message_id: u32, payload: &[u8]) -> Option<Self> {
        let p = Fields(payload);
        let percent = |at| u8::try_from(p.i8(at)).ok().filter(|&left| left <= 100);
        Some(match message_id {
            id::HEARTBEAT => Self::Heartbeat(Heartbeat {
                custom_mode: p.u32(0),
                kind: p.u8(4),
                autopilot: p.u8(5),
                armed: p.u8(6) & 128 != 0,
            }),
            id::SYS_STATUS => Self::Charge(percent(30)),
            id::SYSTEM_TIME => Self::SystemTime { unix_us: p.u64(0), boot_ms: p.u32(8) },
            id::PARAM_VALUE => Self::Parameter(ParameterValue::read(p)),
            id::GPS_RAW_INT => Self::Gps { fix: p.u8(28), alt_mm: Some(p.i32(16)).filter(|&mm| mm != 0) },
            id::LOCAL_POSITION_NED => Self::Local(LocalPosition {
                boot_ms: p.u32(0),
                position_m: [4, 8, 12].map(|at| p.f32(at)),
                velocity_mps: [16, 20, 24].map(|at| p.f32(at)),
            }),
            id::GLOBAL_POSITION_INT => Self::Global(GlobalPosition {
                boot_ms: p.u32(0),
                lat_e7: p.i32(4),
                lon_e7: p.i32(8),
                alt_mm: p.i32(12),
                relative_mm: p.i32(16),
                velocity_cmps: [20, 22, 24].map(|at| p.i16(at)),
            }),
            id::GPS_GLOBAL_ORIGIN => Self::Origin { lat_e7: p.i32(0), lon_e7: p.i32(4) },
            id::COMMAND_ACK => Self::Ack { command: p.u16(0), result: p.u8(2), to: (p.u8(8), p.u8(9)) },
            id::BATTERY_STATUS => {
                Self::Battery(BatteryStatus { id: p.u8(32), function: p.u8(33), percent: percent(35) })
            }
            id::EKF_STATUS_REPORT => Self::Estimator { healthy: Flags::ARDUPILOT.healthy(p.u16(20)) },
            id::ESTIMATOR_STATUS => Self::Estimator { healthy: Flags::PX4.healthy(p.u16(40)) },
            id::EXTENDED_SYS_STATE => Self::OnGround(match p.u8(1) {
                0 => None,
                landed => Some(landed == 1),
            }),
            id::STATUSTEXT => {
                let text = payload.get(1..).unwrap_or_default();
                let text = text.get(..50).unwrap_or(text);
                let end = text.iter().position(|&b| b == 0).unwrap_or(text.len());
                Self::Text { severity: p.u8(0), text: printable(text.get(..end).unwrap_or_default()) }
            }
            _ => return None,
        })
    }
}

/// Text that is safe to print: control characters could move a terminal's cursor.
fn printable(text: &[u8]) -> String {
    String::from_utf8_lossy(text)
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect::<String>()
        .trim()
        .into()
}

/// Which bits of an estimator's flags must be set and which must not.
struct Flags {
    needed: u16,
    bad: u16,
}

impl Flags {
    /// EKF_STATUS_FLAGS. Needed: attitude 1, velocity 2 and (vertical) 4, absolute position 16, absolute
    /// height 32. Bad: constant position 128, uninitialised 1024, GPS glitch 32768.
    const ARDUPILOT: Self = Self { needed: 1 | 2 | 4 | 16 | 32, bad: 128 | 1024 | 32768 };
    /// ESTIMATOR_STATUS_FLAGS: the same, but GPS glitch is 1024 and a bad accelerometer 2048. PX4 sets
    /// 128 (constant position) whenever the vehicle is at rest, so it says nothing; without a source of
    /// position absolute position is missing too.
    const PX4: Self = Self { needed: 1 | 2 | 4 | 16 | 32, bad: 1024 | 2048 };

    const fn healthy(&self, flags: u16) -> bool {
        flags & self.needed == self.needed && flags & self.bad == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_heartbeat_with_zeros_cut_off_is_whole() {
        let payload = [4, 0, 0, 0, 2, 3, 0b1000_1001, 4, 3];
        let heartbeat = Heartbeat { kind: 2, autopilot: 3, custom_mode: 4, armed: true };
        assert_eq!(Telemetry::read(0, &payload), Some(Telemetry::Heartbeat(heartbeat)));
        assert_eq!(
            Telemetry::read(0, &[4]),
            Some(Telemetry::Heartbeat(Heartbeat { kind: 0, autopilot: 0, custom_mode: 4, armed: false }))
        );
    }

    #[test]
    fn charge_that_is_not_known_is_none() {
        let mut status = [0; 31];
        status[30] = 0xff;
        assert_eq!(Telemetry::read(1, &status), Some(Telemetry::Charge(None)));
        status[30] = 77;
        assert_eq!(Telemetry::read(1, &status), Some(Telemetry::Charge(Some(77))));
    }

    #[test]
    fn batteries_are_told_apart() {
        let mut status = [0; 36];
        (status[32], status[33], status[35]) = (1, 4, 20);
        let battery = BatteryStatus { id: 1, function: 4, percent: Some(20) };
        assert_eq!(Telemetry::read(147, &status), Some(Telemetry::Battery(battery)));
        status[35] = 0xff;
        let battery = BatteryStatus { percent: None, ..battery };
        assert_eq!(Telemetry::read(147, &status), Some(Telemetry::Battery(battery)));
    }

    #[test]
    fn texts_are_cut_at_their_end_and_cleaned() {
        let mut payload = [0; 54];
        payload[..13].copy_from_slice(b"\x04Arm: \x1b[2J\tx\0");
        payload[20] = b'!';
        let text = Telemetry::Text { severity: 4, text: "Arm:  [2J x".into() };
        assert_eq!(Telemetry::read(253, &payload), Some(text));
    }

    #[test]
    fn estimators_that_guess_their_position_are_not_healthy() {
        let report = |flags: u16| {
            let mut payload = [0; 22];
            payload[20..].copy_from_slice(&flags.to_le_bytes());
            Telemetry::read(193, &payload)
        };
        assert_eq!(report(0x33f), Some(Telemetry::Estimator { healthy: true }));
        assert_eq!(report(0x33f | 128), Some(Telemetry::Estimator { healthy: false }));
        // Horizontal velocity and position, vertical velocity and position.
        for lost in [2, 16, 4, 32] {
            assert_eq!(report(0x33f & !lost), Some(Telemetry::Estimator { healthy: false }), "{lost}");
        }
    }

    #[test]
    fn px4_at_rest_on_the_ground_is_healthy() {
        let report = |flags: u16| {
            let mut payload = [0; 42];
            payload[40..].copy_from_slice(&flags.to_le_bytes());
            Telemetry::read(230, &payload)
        };
        assert_eq!(report(1023), Some(Telemetry::Estimator { healthy: true }));
        for lost in [2, 16, 4, 32] {
            assert_eq!(report(1023 & !lost), Some(Telemetry::Estimator { healthy: false }), "{lost}");
        }
        assert_eq!(report(1023 | 1024), Some(Telemetry::Estimator { healthy: false }));
    }

    proptest! {
        #[test]
        fn no_payload_is_too_short_or_too_odd(id in 0u32..300, payload in prop::collection::vec(any::<u8>(), 0..255)) {
            let _ = Telemetry::read(id, &payload);
        }
    }
}
