//! The way from the ground into flight: mode change, arming and takeoff, in the autopilot's order.

use super::firmware::{Firmware, Mode};
use super::vehicle_state::VehicleState;

/// The layer is reached within this, mm.
const REACHED_MM: i32 = 1000;
/// A vehicle this high above home is in the air, mm.
const AIRBORNE_MM: i32 = 1500;
/// A takeoff whose COMMAND_ACK was lost shows by this climb, mm.
const CLIMBED_MM: i32 = 700;
/// Lowest takeoff altitude above home, mm.
const MIN_TAKEOFF_MM: i32 = 2000;
/// PX4 requires a second of setpoints before OFFBOARD; a little more is sure.
const PRESTREAM_MS: i64 = 1200;
/// Slowest climb that is waited for, mm/s, and the time that it may begin late, ms.
const SLOWEST_CLIMB_MMPS: i64 = 300;
const CLIMB_START_MS: i64 = 20_000;

/// What to do next towards flight.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum BringUpStep {
    /// Nothing yet.
    Wait,
    /// Change to the mode that follows setpoints.
    SetGuided,
    /// Arm the motors.
    Arm,
    /// Take off to this height above home, unless MAV_CMD_NAV_TAKEOFF is under way.
    TakeOff {
        /// Height above home, mm.
        height_mm: i32,
        /// Parameters of MAV_CMD_NAV_TAKEOFF.
        params: [f32; 7],
    },
    /// The bring-up failed, for this reason.
    GiveUp(String),
}

/// The vehicle as the bring-up sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Situation<'a> {
    pub firmware: Firmware,
    pub mode: Option<Mode>,
    pub armed: bool,
    /// Whether MAV_CMD_NAV_TAKEOFF was accepted and is the command under way.
    pub takeoff_accepted: bool,
    pub state: &'a VehicleState,
}

/// The vehicle when its bring-up began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning {
    pub custom_mode: u32,
    pub armed: bool,
}

/// The bring-up of one vehicle.
#[derive(Clone, Debug)]
pub(super) struct BringUp {
    /// Altitude to fly at, mm above mean sea level.
    layer_mm: i32,
    airborne: bool,
    /// Since when setpoints have been streamed, ms.
    streaming_since: Option<i64>,
    /// Since when a takeoff of ours is under way, ms.
    climbing_since: Option<i64>,
    /// PX4: AUTO.TAKEOFF was seen after our takeoff command.
    took_off: bool,
    /// A vehicle that is armed and in another mode may be taken: the operator asked for it.
    may_take: bool,
    /// The vehicle when the bring-up began.
    began: Option<Beginning>,
    /// Height above home when the takeoff was first commanded, mm.
    from_mm: Option<i32>,
}

impl BringUp {
    pub const fn new(layer_mm: i32) -> Self {
        Self {
            layer_mm,
            airborne: false,
            streaming_since: None,
            climbing_since: None,
            took_off: false,
            may_take: false,
            began: None,
            from_mm: None,
        }
    }

    /// Altitude to fly at, mm above mean sea level.
    pub const fn layer_mm(&self) -> i32 {
        self.layer_mm
    }

    /// In the air, with the takeoff finished.
    pub const fn is_airborne(&self) -> bool {
        self.airborne
    }

    /// Whether a takeoff of ours is under way, or was the last one.
    pub const fn is_taking_off(&self) -> bool {
        self.climbing_since.is_some()
    }

    /// Forgets the takeoff under way, so that a new start begins from scratch.
    pub const fn restart(&mut self) {
        (self.climbing_since, self.took_off) = (None, false);
        (self.began, self.from_mm) = (None, None);
    }

    /// Whether a vehicle may be taken that is armed and in another mode.
    pub const fn may_take(&self) -> bool {
        self.may_take
    }

    pub const fn set_may_take(&mut self, may_take: bool) {
        self.may_take = may_take;
    }

    /// Whether the bring-up has begun.
    pub const fn has_begun(&self) -> bool {
        self.began.is_some()
    }

    /// Begins with the vehicle like this, unless it has begun; returns how it did.
    pub fn begin(&mut self, custom_mode: u32, armed: bool) -> Beginning {
        *self.began.get_or_insert(Beginning { custom_mode, armed })
    }

    /// Whether a takeoff was commanded since the start.
    pub const fn has_commanded_takeoff(&self) -> bool {
        self.from_mm.is_some()
    }

    /// Whether the vehicle has climbed since the takeoff was first commanded.
    pub fn is_climbing(&self, state: &VehicleState) -> bool {
        let Some((from, odometry)) = self.from_mm.zip(state.odometry) else { return false };
        odometry.relative_mm - from >= CLIMBED_MM
    }

    /// Whether it is on the ground, in the `custom_mode` in which the bring-up began.
    pub fn waits_on_ground(&self, custom_mode: u32, state: &VehicleState) -> bool {
        self.began.is_some_and(|began| began.custom_mode == custom_mode)
            && state.odometry.is_some_and(|odometry| odometry.relative_mm < AIRBORNE_MM)
    }

    /// Whether the vehicle is in the air though no takeoff was commanded since the start.
    pub fn is_up_by_another(&self, state: &VehicleState) -> bool {
        self.from_mm.is_none() && state.odometry.is_some_and(|odometry| odometry.relative_mm >= AIRBORNE_MM)
    }

    /// The vehicle rebooted, so it is on the ground.
    pub const fn reboot(&mut self) {
        self.airborne = false;
    }

    /// Whether setpoints are being streamed at `now_ms`.
    pub fn set_streaming(&mut self, streaming: bool, now_ms: i64) {
        self.streaming_since = streaming.then(|| self.streaming_since.unwrap_or(now_ms));
    }

    /// Notes takeoff and landing from telemetry.
    pub fn update(&mut self, state: &VehicleState, armed: bool) {
        let Some(odometry) = state.odometry else { return };
        if !armed || state.on_ground == Some(true) {
            self.airborne = false;
        } else if !self.airborne {
            let reached = (odometry.alt_mm - self.layer_mm).abs() <= REACHED_MM;
            // A vehicle that its pilot took off is in the air at any altitude.
            let by_pilot = self.climbing_since.is_none() && odometry.relative_mm >= AIRBORNE_MM;
            self.airborne = reached && odometry.relative_mm >= AIRBORNE_MM || by_pilot;
        }
    }

    /// The next step, while the gate allows a start.
    pub fn next(&mut self, vehicle: &Situation<'_>, now_ms: i64) -> BringUpStep {
        match vehicle.firmware {
            Firmware::ArduPilot if vehicle.mode != Some(Mode::Guided) => BringUpStep::SetGuided,
            _ if !vehicle.armed && !self.airborne => {
                self.climbing_since = None;
                BringUpStep::Arm
            }
            _ if !self.airborne => self.take_off(vehicle, now_ms),
            // Its takeoff does not show yet, or somebody ended it.
            _ if self.from_mm.is_some() && matches!(vehicle.mode, Some(Mode::Other(_))) => BringUpStep::Wait,
            // In the air; PX4 accepts OFFBOARD only while setpoints are streamed.
            _ if self.streaming_since.is_some_and(|since| now_ms - since >= PRESTREAM_MS) => BringUpStep::SetGuided,
            _ => BringUpStep::Wait,
        }
    }

    fn take_off(&mut self, vehicle: &Situation<'_>, now_ms: i64) -> BringUpStep {
        let Some(odometry) = vehicle.state.odometry else { return BringUpStep::Wait };
        let home_mm = odometry.alt_mm - odometry.relative_mm;
        let height_mm = self.layer_mm - home_mm;
        if height_mm < MIN_TAKEOFF_MM {
            let (layer, home) = (f64::from(self.layer_mm) / 1e3, f64::from(home_mm) / 1e3);
            return BringUpStep::GiveUp(format!(
                "its layer, {layer:.1} m above sea level, is less than 2 m above home ({home:.1} m): raise altitude.base_m"
            ));
        }
        if vehicle.firmware == Firmware::Px4 && vehicle.takeoff_accepted {
            let ours = matches!(vehicle.mode, Some(Mode::TakeoffOrHold | Mode::Guided));
            if self.took_off && !ours {
                let mode = vehicle.state.mode_name(vehicle.firmware);
                return BringUpStep::GiveUp(format!("the mode became {mode} during takeoff: the pilot has it"));
            }
            self.took_off |= ours;
        }
        self.from_mm.get_or_insert(odometry.relative_mm);
        let since = *self.climbing_since.get_or_insert(now_ms);
        let allowed_ms = CLIMB_START_MS + i64::from(height_mm) * 1000 / SLOWEST_CLIMB_MMPS;
        if now_ms - since > allowed_ms {
            let height_m = f64::from(height_mm) / 1e3;
            return BringUpStep::GiveUp(format!("it did not reach {height_m:.1} m in {} s", allowed_ms / 1000));
        }
        BringUpStep::TakeOff { height_mm, params: self.takeoff_params(vehicle.firmware, height_mm) }
    }

    /// Parameters of MAV_CMD_NAV_TAKEOFF. ArduPilot takes the altitude above home, PX4 that above mean
    /// sea level. Yaw and position stay as they are: zero for ArduPilot, NaN for PX4.
    const fn takeoff_params(&self, firmware: Firmware, height_mm: i32) -> [f32; 7] {
        let (here, altitude_m) = match firmware {
            Firmware::ArduPilot => (0.0, height_mm as f32 / 1e3),
            Firmware::Px4 => (f32::NAN, self.layer_mm as f32 / 1e3),
        };
        [0.0, 0.0, 0.0, here, here, here, altitude_m]
    }
}
