//! The messages that a node sends to an autopilot.

use super::fields::{Fields, Payload};
use super::id;
use firmware_core::gate::Setpoint;

/// Type mask of SET_POSITION_TARGET_LOCAL_NED: velocity and acceleration are set, position, yaw and
/// yaw rate are ignored.
pub const VELOCITY_AND_ACCELERATION: u16 = 0x0C07;
/// MAV_FRAME_LOCAL_NED.
const FRAME_LOCAL_NED: u8 = 1;

/// HEARTBEAT of a companion computer.
#[must_use]
pub fn heartbeat() -> Payload {
    let mut payload = Payload::new(id::HEARTBEAT);
    payload.put(&[0; 4]); // custom_mode
    // MAV_TYPE_ONBOARD_CONTROLLER, MAV_AUTOPILOT_INVALID, no base mode, MAV_STATE_ACTIVE, MAVLink 2.
    payload.put(&[18, 8, 0, 4, 3]);
    payload
}

/// COMMAND_LONG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandLong {
    /// MAV_CMD.
    pub command: u16,
    /// How often it was sent before without a COMMAND_ACK.
    pub confirmation: u8,
    /// `param1` to `param7`.
    pub params: [f32; 7],
}

impl CommandLong {
    /// The message that it asks for at a rate, if it does.
    #[must_use]
    pub fn requested_message(&self) -> Option<u32> {
        (self.command == super::mav_cmd::SET_MESSAGE_INTERVAL).then_some(self.params[0] as u32)
    }

    /// The payload for this (system, component).
    #[must_use]
    pub fn payload(&self, target: (u8, u8)) -> Payload {
        let mut payload = Payload::new(id::COMMAND_LONG);
        self.params.iter().for_each(|p| payload.put(&p.to_le_bytes()));
        payload.put(&self.command.to_le_bytes());
        payload.put(&[target.0, target.1, self.confirmation]);
        payload
    }

    /// The system that a payload of message [`id::COMMAND_LONG`] is addressed to.
    #[must_use]
    pub fn target_system(payload: &[u8]) -> u8 {
        Fields(payload).u8(30)
    }

    /// Reads a payload of message [`id::COMMAND_LONG`].
    #[must_use]
    pub fn read(payload: &[u8]) -> Self {
        let fields = Fields(payload);
        let params = [0, 4, 8, 12, 16, 20, 24].map(|at| fields.f32(at));
        Self { command: fields.u16(28), confirmation: fields.u8(32), params }
    }
}

/// SET_POSITION_TARGET_LOCAL_NED with velocity and acceleration; the other fields are not used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPositionTargetLocalNed {
    /// `time_boot_ms`: time since the vehicle's boot.
    pub boot_ms: u32,
    /// Velocity north, east and down, m/s.
    pub velocity_mps: [f32; 3],
    /// Acceleration north, east and down, m/s².
    pub acceleration_mps2: [f32; 3],
}

impl SetPositionTargetLocalNed {
    /// The message for a setpoint that passed the safety gate.
    #[must_use]
    pub fn new(boot_ms: u32, setpoint: &Setpoint) -> Self {
        let si = |thousandths: i32| thousandths as f32 / 1000.0;
        let (v, a) = (setpoint.velocity, setpoint.acceleration);
        Self {
            boot_ms,
            velocity_mps: [si(v.north), si(v.east), si(-setpoint.climb_mm_s)],
            acceleration_mps2: [si(a.north), si(a.east), 0.0],
        }
    }

    /// The payload for this (system, component).
    #[must_use]
    pub fn payload(&self, target: (u8, u8)) -> Payload {
        let mut payload = Payload::new(id::SET_POSITION_TARGET_LOCAL_NED);
        payload.put(&self.boot_ms.to_le_bytes());
        let (position, yaw) = ([0.0; 3], [0.0; 2]);
        let numbers = position.iter().chain(&self.velocity_mps).chain(&self.acceleration_mps2).chain(&yaw);
        numbers.for_each(|n: &f32| payload.put(&n.to_le_bytes()));
        payload.put(&VELOCITY_AND_ACCELERATION.to_le_bytes());
        payload.put(&[target.0, target.1, FRAME_LOCAL_NED]);
        payload
    }

    /// The system that a payload of message [`id::SET_POSITION_TARGET_LOCAL_NED`] is addressed to.
    #[must_use]
    pub fn target_system(payload: &[u8]) -> u8 {
        Fields(payload).u8(50)
    }

    /// Reads a payload of message [`id::SET_POSITION_TARGET_LOCAL_NED`].
    #[must_use]
    pub fn read(payload: &[u8]) -> Self {
        let fields = Fields(payload);
        Self {
            boot_ms: fields.u32(0),
            velocity_mps: [16, 20, 24].map(|at| fields.f32(at)),
            acceleration_mps2: [28, 32, 36].map(|at| fields.f32(at)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_read_back_as_they_were_made() {
        let command = CommandLong { command: 22, confirmation: 3, params: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.5] };
        assert_eq!(CommandLong::read(command.payload((7, 1)).bytes()), command);
        let setpoint = SetPositionTargetLocalNed {
            boot_ms: 0x0102_0304,
            velocity_mps: [1.0, -2.0, 0.5],
            acceleration_mps2: [0.25, 3.0, 0.0],
        };
        assert_eq!(SetPositionTargetLocalNed::read(setpoint.payload((7, 1)).bytes()), setpoint);
    }
}
