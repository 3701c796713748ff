//! The stages that a node goes through with its autopilot, and how a flight gets there.

use crate::flight::Flight;
use sitl_bridge::autopilot::{Firmware, Stage as NodeStage};
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::OperatorCommand;

/// A stage of the table in `docs/safety.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    SilentOnGround,
    SilentInAir,
    SubscribingOnGround,
    SubscribingInAir,
    Idle,
    ModeAsked,
    ModeAccepted,
    ArmingAsked,
    ArmingAccepted,
    TakeoffAsked,
    TakeoffAccepted,
    Climb,
    Climbed,
    Flight,
    Failed,
    Released,
    ClockAhead,
    ClockBack,
    ReturnAsked,
    Returning,
}

impl Stage {
    /// The row's name in the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SilentOnGround => "not heard yet, on the ground",
            Self::SilentInAir => "not heard yet, in the air in GUIDED",
            Self::SubscribingOnGround => "asking for rates, on the ground",
            Self::SubscribingInAir => "asking for rates again, in flight",
            Self::Idle => "waiting for the estimator",
            Self::ModeAsked => "GUIDED asked for",
            Self::ModeAccepted => "GUIDED accepted, no heartbeat yet",
            Self::ArmingAsked => "arming asked for",
            Self::ArmingAccepted => "armed, no heartbeat yet",
            Self::TakeoffAsked => "takeoff asked for",
            Self::TakeoffAccepted => "takeoff accepted, no heartbeat yet",
            Self::Climb => "climbing",
            Self::Climbed => "climbed, before OFFBOARD",
            Self::Flight => "flight",
            Self::Failed => "bring-up failed, in the air",
            Self::Released => "released",
            Self::ClockAhead => "clock leapt ahead",
            Self::ClockBack => "clock leapt back",
            Self::ReturnAsked => "return not answered yet",
            Self::Returning => "returning by `return`",
        }
    }

    /// Whether the vehicle is in the air.
    pub const fn is_in_air(self, firmware: Firmware) -> bool {
        match self {
            Self::ModeAsked | Self::ModeAccepted => matches!(firmware, Firmware::Px4),
            Self::SilentOnGround | Self::SubscribingOnGround | Self::Idle => false,
            Self::ArmingAsked | Self::ArmingAccepted | Self::TakeoffAsked | Self::TakeoffAccepted => false,
            _ => true,
        }
    }

    /// A flight with `--takeoff` that has come so far; `None` where the firmware has no such stage.
    pub fn reach(self, firmware: Firmware) -> Option<Flight> {
        let mut flight = Flight::new(5, firmware, true);
        flight.vehicle.offboard_loss_ms = Some(1000);
        // The pilot's own mode, in which the bring-up begins.
        flight.vehicle.custom_mode = pilots_first_mode(firmware);
        let guided = if firmware == Firmware::Px4 { 6.0 } else { 4.0 };
        let mode_asked =
            |f: &Flight| f.vehicle.commands.iter().any(|c| c.0 == mav_cmd::DO_SET_MODE && c.1[1] == guided);
        let asked = |command: u16| move |f: &Flight| f.vehicle.commands.iter().any(|c| c.0 == command);
        let stage = |stage: NodeStage| move |f: &Flight| f.node.stage() == stage;
        let there = match self {
            Self::SilentOnGround => (0..10).all(|_| flight.idle(100).is_empty()),
            Self::SilentInAir => {
                flight.vehicle.armed = true;
                flight.vehicle.custom_mode = if firmware == Firmware::Px4 { 6 << 16 } else { 4 };
                flight.vehicle.height_mm = 12_000.0;
                // Whoever flew it before still sends setpoints.
                flight.vehicle.offboard_loss_ms = None;
                (0..10).all(|_| flight.idle(100).is_empty())
            }
            Self::SubscribingOnGround => {
                flight.vehicle.ignore = Some(mav_cmd::SET_MESSAGE_INTERVAL);
                flight.ticks(6);
                flight.node.stage() == NodeStage::Subscribing
            }
            Self::SubscribingInAir => {
                in_flight(&mut flight);
                flight.vehicle.without_positions = true;
                flight.vehicle.ignore = Some(mav_cmd::SET_MESSAGE_INTERVAL);
                flight.until(10, stage(NodeStage::Subscribing))
            }
            Self::Idle => {
                flight.vehicle.healthy = false;
                flight.ticks(50);
                flight.node.stage() == NodeStage::Idle
            }
            Self::ModeAsked => {
                flight.vehicle.ignore = Some(mav_cmd::DO_SET_MODE);
                flight.until(60, mode_asked)
            }
            Self::ModeAccepted => {
                let asked = flight.until(60, mode_asked);
                unheard(&mut flight) && asked && flight.vehicle.is_guided()
            }
            Self::ArmingAsked => {
                flight.vehicle.ignore = Some(mav_cmd::COMPONENT_ARM_DISARM);
                flight.until(60, asked(mav_cmd::COMPONENT_ARM_DISARM))
            }
            Self::ArmingAccepted => {
                let asked = flight.until(60, asked(mav_cmd::COMPONENT_ARM_DISARM));
                unheard(&mut flight) && asked && flight.vehicle.armed
            }
            Self::TakeoffAsked => {
                flight.vehicle.ignore = Some(mav_cmd::NAV_TAKEOFF);
                flight.until(60, asked(mav_cmd::NAV_TAKEOFF))
            }
            Self::TakeoffAccepted => {
                flight.vehicle.ceiling_mm = Some(0.0);
                let asked = flight.until(60, asked(mav_cmd::NAV_TAKEOFF));
                unheard(&mut flight) && asked && flight.vehicle.takes_off()
            }
            Self::Climb => flight.until(60, |f| (3000.0..9000.0).contains(&f.vehicle.height_mm)),
            Self::Climbed if firmware == Firmware::ArduPilot => return None,
            Self::Climbed => flight.until(60, |f| f.node.is_airborne()) && !mode_asked(&flight),
            Self::Failed => {
                flight.vehicle.ceiling_mm = Some(6000.0);
                flight.until(200, stage(NodeStage::Failed))
            }
            Self::Flight | Self::Released | Self::ClockAhead | Self::ClockBack => {
                in_flight(&mut flight);
                match self {
                    Self::Released => {
                        flight.node.command(OperatorCommand::Release);
                        flight.ticks(40);
                    }
                    Self::ClockAhead => {
                        flight.vehicle.boot_ms += 59_000;
                        flight.ticks(10);
                    }
                    Self::ClockBack => {
                        flight.vehicle.boot_ms -= 9000;
                        flight.ticks(10);
                    }
                    _ => {}
                }
                true
            }
            Self::ReturnAsked => {
                in_flight(&mut flight);
                flight.vehicle.ignore = Some(mav_cmd::DO_SET_MODE);
                flight.node.command(OperatorCommand::Return);
                flight.ticks(1);
                true
            }
            Self::Returning => {
                in_flight(&mut flight);
                flight.node.command(OperatorCommand::Return);
                flight.ticks(10);
                !flight.vehicle.is_guided()
            }
        };
        assert!(there, "{self:?} on {firmware:?} is not reached: {:?}", flight.words());
        Some(flight)
    }
}

/// The mode in which the vehicle is found: LOITER, POSCTL.
pub const fn pilots_first_mode(firmware: Firmware) -> u32 {
    if matches!(firmware, Firmware::Px4) { 3 << 16 } else { 5 }
}

/// What holds the stage is over: commands are obeyed, everything is heard.
pub fn let_go_on(flight: &mut Flight) {
    let vehicle = &mut flight.vehicle;
    (vehicle.ignore, vehicle.without_heartbeats, vehicle.without_positions, vehicle.healthy) =
        (None, false, false, true);
    vehicle.ceiling_mm = vehicle.ceiling_mm.filter(|&ceiling| ceiling == 6000.0);
}

fn in_flight(flight: &mut Flight) {
    assert!(flight.until(90, |f| f.decisions.len() > 1), "{:?}", flight.words());
}

/// The answer to the last command comes, and no heartbeat.
fn unheard(flight: &mut Flight) -> bool {
    flight.vehicle.without_heartbeats = true;
    flight.ticks(2);
    true
}
