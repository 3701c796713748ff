//! What a node reads of an autopilot's messages.
//!
//! The few fields that matter are taken by their place on the wire (MAVLink's common message
//! set; EKF_STATUS_REPORT is ArduPilot's). Numbers of enumerations stay numbers: a value that
//! came with a newer dialect must not make a heartbeat unreadable.

/// A message of the autopilot, as far as it matters here.
#[derive(Clone, Debug, PartialEq)]
pub enum Telemetry {
    /// HEARTBEAT (0).
    Heartbeat(Heartbeat),
    /// SYS_STATUS (1) or BATTERY_STATUS (147): charge left, percent; `None` when it is not known.
    Battery(Option<u8>),
    /// SYSTEM_TIME (2).
    SystemTime {
        /// Unix time, µs; 0 until the autopilot knows it.
        unix_us: u64,
        /// Since boot, ms.
        boot_ms: u32,
    },
    /// GPS_RAW_INT (24): kind of fix, 3 and above are good for flight.
    GpsFix(u8),
    /// LOCAL_POSITION_NED (32).
    Local(LocalPosition),
    /// GLOBAL_POSITION_INT (33).
    Global(GlobalPosition),
    /// GPS_GLOBAL_ORIGIN (49): where the estimator has its zero.
    Origin {
        /// Latitude, 1e-7 degrees.
        lat_e7: i32,
        /// Longitude, 1e-7 degrees.
        lon_e7: i32,
    },
    /// COMMAND_ACK (77).
    Ack {
        /// The command that was answered, MAV_CMD.
        command: u16,
        /// MAV_RESULT.
        result: u8,
    },
    /// EKF_STATUS_REPORT (193) or ESTIMATOR_STATUS (230).
    Estimator {
        /// Whether attitude, velocity and absolute position are there and trusted.
        healthy: bool,
    },
    /// EXTENDED_SYS_STATE (245): whether the vehicle stands on the ground, where it knows.
    OnGround(Option<bool>),
    /// STATUSTEXT (253).
    Text {
        /// 0 (emergency) to 7 (debug).
        severity: u8,
        /// The text.
        text: String,
    },
}

/// HEARTBEAT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heartbeat {
    /// MAV_TYPE.
    pub kind: u8,
    /// MAV_AUTOPILOT; 8 is none: a ground station or another companion.
    pub autopilot: u8,
    /// The autopilot's own number of the mode.
    pub custom_mode: u32,
    /// Motors may turn.
    pub armed: bool,
}

/// LOCAL_POSITION_NED, in the frame of the estimator's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalPosition {
    /// Since boot, ms.
    pub boot_ms: u32,
    /// North, east, down, m.
    pub position_m: [f32; 3],
    /// North, east, down, m/s.
    pub velocity_mps: [f32; 3],
}

impl LocalPosition {
    /// Whether every number is one.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.position_m.iter().chain(&self.velocity_mps).all(|v| v.is_finite())
    }
}

/// GLOBAL_POSITION_INT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlobalPosition {
    /// Since boot, ms.
    pub boot_ms: u32,
    /// Latitude, 1e-7 degrees.
    pub lat_e7: i32,
    /// Longitude, 1e-7 degrees.
    pub lon_e7: i32,
    /// Above mean sea level, mm.
    pub alt_mm: i32,
    /// Above home, mm.
    pub relative_mm: i32,
    /// North, east, down, cm/s.
    pub velocity_cmps: [i16; 3],
}

impl Telemetry {
    /// Reads a payload in the order of the wire (zeros at its end may be missing); `None` for
    /// messages that do not matter.
    #[must_use]
    pub fn read(message_id: u32, payload: &[u8]) -> Option<Self> {
        let p = Payload(payload);
        let percent = |at| u8::try_from(p.i8(at)).ok().filter(|&left| left <= 100);
        Some(match message_id {
            0 => Self::Heartbeat(Heartbeat {
                custom_mode: p.u32(0),
                kind: p.u8(4),
                autopilot: p.u8(5),
                armed: p.u8(6) & 128 != 0,
            }),
            1 => Self::Battery(percent(30)),
            2 => Self::SystemTime { unix_us: u64::from_le_bytes(p.get(0)), boot_ms: p.u32(8) },
            24 => Self::GpsFix(p.u8(28)),
            32 => Self::Local(LocalPosition {
                boot_ms: p.u32(0),
                position_m: [4, 8, 12].map(|at| p.f32(at)),
                velocity_mps: [16, 20, 24].map(|at| p.f32(at)),
            }),
            33 => Self::Global(GlobalPosition {
                boot_ms: p.u32(0),
                lat_e7: p.i32(4),
                lon_e7: p.i32(8),
                alt_mm: p.i32(12),
                relative_mm: p.i32(16),
                velocity_cmps: [20, 22, 24].map(|at| i16::from_le_bytes(p.get(at))),
            }),
            49 => Self::Origin { lat_e7: p.i32(0), lon_e7: p.i32(4) },
            77 => Self::Ack { command: p.u16(0), result: p.u8(2) },
            147 => Self::Battery(percent(35)),
            193 => Self::Estimator { healthy: Flags::ARDUPILOT.healthy(p.u16(20)) },
            230 => Self::Estimator { healthy: Flags::PX4.healthy(p.u16(40)) },
            245 => Self::OnGround(match p.u8(1) {
                0 => None,
                landed => Some(landed == 1),
            }),
            253 => {
                let text = payload.get(1..).unwrap_or_default();
                let text = text.get(..50).unwrap_or(text);
                let end = text.iter().position(|&b| b == 0).unwrap_or(text.len());
                Self::Text { severity: p.u8(0), text: printable(text.get(..end).unwrap_or_default()) }
            }
            _ => return None,
        })
    }
}

/// Text that may go to a terminal: an autopilot's words must not move its cursor.
fn printable(text: &[u8]) -> String {
    String::from_utf8_lossy(text)
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect::<String>()
        .trim()
        .into()
}

/// Bits of the estimators' flags.
struct Flags {
    needed: u16,
    bad: u16,
}

impl Flags {
    /// EKF_STATUS_FLAGS. Needed: attitude 1, velocity 2 and 4, absolute position 16. Bad:
    /// constant position 128, uninitialised 1024, GPS glitch 32768.
    const ARDUPILOT: Self = Self { needed: 1 | 2 | 4 | 16, bad: 128 | 1024 | 32768 };
    /// ESTIMATOR_STATUS_FLAGS: the same, but GPS glitch is 1024 and a bad accelerometer 2048.
    const PX4: Self = Self { needed: 1 | 2 | 4 | 16, bad: 128 | 1024 | 2048 };

    const fn healthy(&self, flags: u16) -> bool {
        flags & self.needed == self.needed && flags & self.bad == 0
    }
}

/// Little-endian fields; what lies beyond the end is zero, as MAVLink 2 has it.
struct Payload<'a>(&'a [u8]);

impl Payload<'_> {
    fn get<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut field = [0; N];
        for (out, &b) in field.iter_mut().zip(self.0.iter().skip(at)) {
            *out = b;
        }
        field
    }

    fn u8(&self, at: usize) -> u8 {
        self.get::<1>(at)[0]
    }

    fn i8(&self, at: usize) -> i8 {
        i8::from_le_bytes(self.get(at))
    }

    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes(self.get(at))
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.get(at))
    }

    fn i32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.get(at))
    }

    fn f32(&self, at: usize) -> f32 {
        f32::from_le_bytes(self.get(at))
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
        assert_eq!(Telemetry::read(1, &status), Some(Telemetry::Battery(None)));
        status[30] = 77;
        assert_eq!(Telemetry::read(1, &status), Some(Telemetry::Battery(Some(77))));
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
        assert_eq!(report(0x33f & !16), Some(Telemetry::Estimator { healthy: false }));
    }

    proptest! {
        #[test]
        fn no_payload_is_too_short_or_too_odd(id in 0u32..300, payload in prop::collection::vec(any::<u8>(), 0..255)) {
            let _ = Telemetry::read(id, &payload);
        }
    }
}
