//! The autopilot's side of a node: telemetry, the command protocol, and the bring-up from the
//! ground into flight.
//!
//! Nothing here owns a socket or a clock. `Autopilot::handle` takes in decoded telemetry,
//! `Autopilot::poll` returns the command to send. Each poll looks at the state of the vehicle and
//! requests the next thing that is missing, so a lost message or a reboot only costs time:
//!
//! | ArduPilot | PX4 |
//! |---|---|
//! | message intervals, one after another | the same |
//! | position, time, estimator healthy | the same |
//! | GUIDED | armed |
//! | armed | takeoff, until near the layer's altitude |
//! | takeoff, until near the layer's altitude | setpoints for a second, then OFFBOARD |

mod answers;
mod batteries;
mod bring_up;
mod client;
mod clock;
mod clock_rate;
mod command;
mod control;
mod firmware;
mod identity;
mod message_rates;
mod notice;
mod odometry;
mod order;
mod orders;
mod parameter_values;
mod parameter_watch;
mod parameters;
mod reliance;
mod shared_id;
mod stage;
mod standing;
mod strictness;
mod supervision;
mod takeover;
mod vehicle_state;

pub(crate) use client::{Autopilot, Clearance};
pub(crate) use clock::VehicleClock;
pub use firmware::{Firmware, Mode, UnsupportedVehicle};
pub use notice::Notice;
pub(crate) use odometry::Odometry;
pub(crate) use order::{Order, Ordered};
pub(crate) use parameter_watch::Reliance;
pub use stage::Stage;
pub(crate) use standing::{STANDING_S, STANDING_SPEED};
pub use standing::{Speeds, left_standing_m};
pub(crate) use vehicle_state::{TelemetryUpdate, VehicleState};
