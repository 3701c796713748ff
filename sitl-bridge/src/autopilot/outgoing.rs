//! What a node sends to an autopilot.

use firmware_core::gate::Setpoint;

/// MAV_CMD numbers that are used.
pub mod command {
    /// Takes off to a height.
    pub const TAKEOFF: u16 = 22;
    /// Changes the mode.
    pub const SET_MODE: u16 = 176;
    /// Arms or disarms.
    pub const ARM: u16 = 400;
    /// Asks for a message at a rate.
    pub const MESSAGE_INTERVAL: u16 = 511;
}

/// SET_POSITION_TARGET_LOCAL_NED's mask: velocity and acceleration count, position and yaw not.
pub const VELOCITY_AND_ACCELERATION: u16 = 0x0C07;
const FRAME_LOCAL_NED: u8 = 1;

/// A message to the autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outgoing {
    /// HEARTBEAT of an onboard controller.
    Heartbeat,
    /// COMMAND_LONG.
    Command {
        /// MAV_CMD.
        command: u16,
        /// How often it was sent before.
        confirmation: u8,
        /// Its seven parameters.
        params: [f32; 7],
    },
    /// SET_POSITION_TARGET_LOCAL_NED with velocity and acceleration.
    Setpoint {
        /// The vehicle's time.
        boot_ms: u32,
        /// What the gate let through.
        setpoint: Setpoint,
    },
}

/// A payload in the order of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Payload {
    /// Message id.
    pub id: u32,
    bytes: [u8; 53],
    len: usize,
}

impl Payload {
    /// The payload's bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

impl Outgoing {
    /// As a payload for this system and component.
    #[must_use]
    pub fn payload(&self, target: (u8, u8)) -> Payload {
        match *self {
            Self::Heartbeat => {
                let mut w = Writer::new(0);
                w.put(&[0; 4]); // custom mode
                w.put(&[18, 8, 0, 4, 3]); // onboard controller, no autopilot, no base mode, active, MAVLink 2
                w.0
            }
            Self::Command { command, confirmation, params } => {
                let mut w = Writer::new(76);
                params.iter().for_each(|p| w.put(&p.to_le_bytes()));
                w.put(&command.to_le_bytes());
                w.put(&[target.0, target.1, confirmation]);
                w.0
            }
            Self::Setpoint { boot_ms, setpoint } => {
                let mut w = Writer::new(84);
                w.put(&boot_ms.to_le_bytes());
                let si = |thousandths: i32| thousandths as f32 / 1000.0;
                let (v, a) = (setpoint.velocity, setpoint.acceleration);
                let numbers =
                    [0.0, 0.0, 0.0, si(v.north), si(v.east), si(-setpoint.climb_mm_s), si(a.north), si(a.east)];
                // Then the vertical acceleration, yaw and its rate, all zero.
                numbers.iter().chain(&[0.0; 3]).for_each(|n| w.put(&n.to_le_bytes()));
                w.put(&VELOCITY_AND_ACCELERATION.to_le_bytes());
                w.put(&[target.0, target.1, FRAME_LOCAL_NED]);
                w.0
            }
        }
    }
}

struct Writer(Payload);

impl Writer {
    const fn new(id: u32) -> Self {
        Self(Payload { id, bytes: [0; 53], len: 0 })
    }

    fn put(&mut self, field: &[u8]) {
        let end = self.0.len + field.len();
        self.0.bytes[self.0.len..end].copy_from_slice(field);
        self.0.len = end;
    }
}
