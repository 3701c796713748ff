//! MAV_CMD numbers of the commands that a node sends in COMMAND_LONG.

/// MAV_CMD_NAV_TAKEOFF: take off to an altitude.
pub const NAV_TAKEOFF: u16 = 22;
/// MAV_CMD_DO_SET_MODE: change the flight mode.
pub const DO_SET_MODE: u16 = 176;
/// MAV_CMD_COMPONENT_ARM_DISARM: arm or disarm the motors.
pub const COMPONENT_ARM_DISARM: u16 = 400;
/// MAV_CMD_SET_MESSAGE_INTERVAL: ask for a message at a rate.
pub const SET_MESSAGE_INTERVAL: u16 = 511;
