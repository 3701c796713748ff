//! The MAVLink messages that a node sends and reads, with their fields by offset on the wire.
//!
//! Layouts are those of MAVLink's common message set; EKF_STATUS_REPORT is ArduPilot's. Values of
//! enumerations stay numbers: a value that a newer dialect added must not make a HEARTBEAT
//! unreadable, as it would with generated types.

mod fields;
pub mod id;
pub mod mav_cmd;
mod outgoing;
mod parameter;
mod telemetry;
mod v2_extension;

pub use fields::Payload;
pub use outgoing::{CommandLong, SetPositionTargetLocalNed, VELOCITY_AND_ACCELERATION, heartbeat};
pub use parameter::{ParamRequestRead, ParameterValue};
pub use telemetry::{BatteryStatus, GlobalPosition, Heartbeat, LocalPosition, Telemetry};
pub use v2_extension::V2Extension;
