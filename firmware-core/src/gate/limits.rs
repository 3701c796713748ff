//! The gate's settings, each with its default, unit and bounds.

/// What to do when no other UAV is heard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SwarmLoss {
    /// Fly on alone: no neighbours is an ordinary case, which the policy was trained for.
    #[default]
    FlyOn,
    /// Hold until somebody is heard again.
    Hold,
}

/// The gate's settings. [`Limits::default`] is for real flight at the default scale (1 u = 2.5 m, 1 step = 2 s).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Greatest horizontal speed, mm/s. 5,000: 4 u/step.
    pub max_speed_mm_s: u32,
    /// Greatest horizontal acceleration, mm/s². 2,500: 4 u/step², and what ArduCopter tracks by default.
    pub max_acceleration_mm_s2: u32,
    /// Deceleration that the vehicle surely reaches in any direction, mm/s²; the way to the fence is measured by
    /// it. At most [`Self::max_acceleration_mm_s2`]. 2,000.
    pub braking_mm_s2: u32,
    /// Time from a measurement until the vehicle follows the setpoint made of it, ms: transport, a tick, and the
    /// autopilot's own lag. 600.
    pub reaction_ms: u32,

    /// Distance from the fence that is kept, mm. Nearer than this the vehicle is led back. 3,000.
    pub fence_margin_mm: u32,
    /// Speed of leading back inside, mm/s. 1,000.
    pub inward_mm_s: u32,
    /// Outside the fence for this long, the vehicle returns home, ms. 10,000.
    pub fence_stuck_ms: u32,

    /// Lowest altitude, mm above the mission's origin. 5,000.
    pub altitude_floor_mm: i32,
    /// Greatest altitude, mm above the mission's origin. 120,000.
    pub altitude_ceiling_mm: i32,
    /// How far outside the band the vehicle may be before it holds, mm. 3,000.
    pub altitude_slack_mm: u32,
    /// Farther than this from its altitude layer the vehicle does not move sideways, mm. 2,500: half the usual distance
    /// of two layers. It goes on at half of it.
    pub layer_mm: u32,
    /// Greatest vertical speed, mm/s. 1,500.
    pub climb_mm_s: u32,

    /// The longest time between two ticks that deadlines are stated for, ms. 200.
    pub tick_ms: u32,
    /// Greatest age of the own state, ms. 1,000.
    pub stale_ms: u32,
    /// Greatest age of the autopilot's heartbeat, ms (it comes once a second). 3,500.
    pub heartbeat_ms: u32,
    /// How long the vehicle's clock may stand still by the own computer's clock, ms. 2,000; longer for simulators
    /// that may pause.
    pub link_wall_ms: u32,
    /// Whether the vehicle's clock runs as fast as the own computer's. True; false for simulators.
    pub real_time: bool,
    /// In real time: how far the vehicle's clock may run ahead of the own computer's between two ticks, ms. 2,000.
    pub clock_slip_ms: u32,
    /// How far back a time may be and still be taken for a message out of order, ms. 500.
    pub reorder_ms: u32,
    /// Greatest step of the vehicle's clock between two ticks, ms: after a longer silence it counts as another
    /// vehicle. 10,000.
    pub max_gap_ms: u32,
    /// How long a bad flag must last before it counts, ms. 500.
    pub confirm_ms: u32,
    /// How long a cause must be over before the actor flies again, ms. 2,000.
    pub clear_ms: u32,
    /// How long setpoints of zero velocity are sent before silence, ms. 1,000. With 0 silence begins at once.
    pub stop_ms: u32,
    /// A stop that lasted longer no longer ends by itself, ms. 30,000.
    pub release_ms: u32,
    /// How long the measured position may stand still while the vehicle should be moving, ms. 1,500. Nothing
    /// switches the test off (a vehicle that moves in leaps, once a step).
    pub frozen_ms: Option<u32>,
    /// How much farther than it can fly the measured position or height may move between two measurements, mm. 5,000. Nothing
    /// switches the test off.
    pub jump_mm: Option<u32>,
    /// Least GPS fix type. 3: a 3D fix. 0 asks for no GPS.
    pub least_gps_fix: u8,

    /// The vehicle returns home when no more than this of its battery is left, thousandths. 250.
    pub battery_permille: u16,
    /// How long the battery must be low before it counts, ms: it sags in a climb. 3,000.
    pub battery_confirm_ms: u32,
    /// Greatest age of the decision that is flown, ms. 4,500: two steps and a bit.
    pub decision_ms: u32,
    /// What to do when no other UAV was heard for [`Self::swarm_ms`]. [`SwarmLoss::FlyOn`].
    pub swarm_loss: SwarmLoss,
    /// When the swarm counts as lost, ms. 6,000: three steps.
    pub swarm_ms: u32,
    /// How long GUIDED, arming and takeoff may take, ms. 180,000.
    pub bring_up_ms: u32,
    /// Whether setpoints are streamed before the mode is taken, as PX4 wants. False.
    pub stream_before_mode: bool,
    /// The command to return is given again after this time while the mode stays, ms. 1,000.
    pub return_retry_ms: u32,
    /// How often the command to return is given at most. 3.
    pub return_attempts: u8,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_speed_mm_s: 5000,
            max_acceleration_mm_s2: 2500,
            braking_mm_s2: 2000,
            reaction_ms: 600,
            fence_margin_mm: 3000,
            inward_mm_s: 1000,
            fence_stuck_ms: 10_000,
            altitude_floor_mm: 5000,
            altitude_ceiling_mm: 120_000,
            altitude_slack_mm: 3000,
            layer_mm: 2500,
            climb_mm_s: 1500,
            tick_ms: 200,
            stale_ms: 1000,
            heartbeat_ms: 3500,
            link_wall_ms: 2000,
            real_time: true,
            clock_slip_ms: 2000,
            reorder_ms: 500,
            max_gap_ms: 10_000,
            confirm_ms: 500,
            clear_ms: 2000,
            stop_ms: 1000,
            release_ms: 30_000,
            frozen_ms: Some(1500),
            jump_mm: Some(5000),
            least_gps_fix: 3,
            battery_permille: 250,
            battery_confirm_ms: 3000,
            decision_ms: 4500,
            swarm_loss: SwarmLoss::FlyOn,
            swarm_ms: 6000,
            bring_up_ms: 180_000,
            stream_before_mode: false,
            return_retry_ms: 1000,
            return_attempts: 3,
        }
    }
}

/// A setting that the gate cannot work with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LimitsError {
    /// Outside its bounds.
    #[error("{name} is {value}, it must be {least} to {most}")]
    OutOfRange {
        /// The setting.
        name: &'static str,
        /// What it is.
        value: i64,
        /// Least value.
        least: i64,
        /// Greatest value.
        most: i64,
    },
    /// The vehicle cannot turn inside the circle at its greatest speed.
    #[error(
        "a circular fence of {radius_mm} mm is too small for the greatest speed, it must be at least {least_mm} mm"
    )]
    CircleTooSmall {
        /// What it is, mm.
        radius_mm: u32,
        /// What it must be, mm.
        least_mm: u32,
    },
}

/// An hour, ms: the longest time that can be set.
const HOUR_MS: u32 = 3_600_000;

impl Limits {
    /// For a simulated autopilot, whose clock may run at any rate, and may wait for others.
    #[must_use]
    pub fn simulation() -> Self {
        Self { real_time: false, link_wall_ms: 10_000, ..Self::default() }
    }

    /// For the scenario's own dynamics: the vehicle stands still within a step and leaps at its end, so nothing
    /// about its motion can be doubted. Rounding must not shorten anything either, so the limits are twice the
    /// scenario's. The fence must lie beyond the map by the way to stop.
    #[must_use]
    pub fn ideal() -> Self {
        let flight = Self::default();
        Self {
            max_speed_mm_s: flight.max_speed_mm_s * 2,
            max_acceleration_mm_s2: flight.max_acceleration_mm_s2 * 2,
            frozen_ms: None,
            jump_mm: None,
            ..Self::simulation()
        }
    }

    /// Whether the gate can work with these settings.
    ///
    /// # Errors
    /// The first setting that is out of its bounds.
    pub fn check(&self) -> Result<(), LimitsError> {
        let speed = i64::from(self.max_speed_mm_s);
        let acceleration = i64::from(self.max_acceleration_mm_s2);
        let rates = [
            ("max_speed_mm_s", speed, 100, 50_000),
            ("max_acceleration_mm_s2", acceleration, 100, 50_000),
            ("braking_mm_s2", self.braking_mm_s2.into(), 100, acceleration),
            ("inward_mm_s", self.inward_mm_s.into(), 0, speed),
            ("climb_mm_s", self.climb_mm_s.into(), 0, 20_000),
            ("fence_margin_mm", self.fence_margin_mm.into(), 0, 1_000_000),
            ("altitude_floor_mm", self.altitude_floor_mm.into(), -1_000_000, 10_000_000),
            ("altitude_ceiling_mm", self.altitude_ceiling_mm.into(), self.altitude_floor_mm.into(), 10_000_000),
            ("altitude_slack_mm", self.altitude_slack_mm.into(), 0, 1_000_000),
            ("layer_mm", self.layer_mm.into(), 100, 1_000_000),
            ("battery_permille", self.battery_permille.into(), 0, 1000),
            ("tick_ms", self.tick_ms.into(), 10, 1000),
            ("reaction_ms", self.reaction_ms.into(), self.tick_ms.into(), 5000),
            ("stale_ms", self.stale_ms.into(), self.tick_ms.into(), 5000),
            ("reorder_ms", self.reorder_ms.into(), 0, self.max_gap_ms.into()),
        ];
        let times = [
            ("fence_stuck_ms", self.fence_stuck_ms),
            ("heartbeat_ms", self.heartbeat_ms),
            ("link_wall_ms", self.link_wall_ms),
            ("clock_slip_ms", self.clock_slip_ms),
            ("max_gap_ms", self.max_gap_ms),
            ("confirm_ms", self.confirm_ms),
            ("clear_ms", self.clear_ms),
            ("stop_ms", self.stop_ms),
            ("release_ms", self.release_ms),
            ("frozen_ms", self.frozen_ms.unwrap_or(0)),
            ("battery_confirm_ms", self.battery_confirm_ms),
            ("decision_ms", self.decision_ms),
            ("swarm_ms", self.swarm_ms),
            ("bring_up_ms", self.bring_up_ms),
            ("return_retry_ms", self.return_retry_ms),
        ];
        let times = times.into_iter().map(|(name, ms)| (name, i64::from(ms), 0, i64::from(HOUR_MS)));
        for (name, value, least, most) in rates.into_iter().chain(times) {
            if value < least || value > most {
                return Err(LimitsError::OutOfRange { name, value, least, most });
            }
        }
        Ok(())
    }
}
