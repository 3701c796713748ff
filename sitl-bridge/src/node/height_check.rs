//! The height check: what the estimator and the GPS say of the height once the climb is over.
//!
//! The height that a UAV keeps is its estimator's: the GPS height when it was switched on, and the change of air
//! pressure since. The GPS's own height now is another word on it.

use crate::autopilot::{Notice, VehicleState};

/// Least GPS_FIX_TYPE whose height counts.
const LEAST_FIX: u8 = 3;
/// Slower than this it does not climb, m/s.
const SLOW_MPS: f64 = 0.5;

/// Checks the height after each climb.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeightCheck {
    /// Heights may differ by so much, mm.
    limit_mm: u32,
    /// Home's altitude above mean sea level when the vehicle was last on the ground and disarmed, mm.
    home_mm: Option<i32>,
    /// The climb is over, and was checked.
    checked: bool,
    doubted: bool,
    /// The operator flies all the same.
    waived: bool,
}

impl HeightCheck {
    /// Heights may differ by `limit_m`, m.
    pub fn new(limit_m: f64) -> Self {
        Self { limit_mm: (limit_m * 1000.0) as u32, home_mm: None, checked: false, doubted: false, waived: false }
    }

    /// Whether the height is in doubt.
    pub const fn is_doubted(&self) -> bool {
        self.doubted && !self.waived
    }

    /// The operator flies with the height in doubt, until the next climb.
    pub const fn waive(&mut self) {
        self.waived = true;
    }

    /// Takes in the vehicle's state. Returns a notice when the height comes into doubt after a climb, or out
    /// of it.
    pub fn update(&mut self, state: &VehicleState, airborne: bool) -> Option<Notice> {
        let odometry = state.odometry?;
        let home_mm = odometry.alt_mm - odometry.relative_mm;
        if !airborne {
            (self.checked, self.doubted, self.waived) = (false, false, false);
            if !state.is_armed() {
                self.home_mm = Some(home_mm);
            }
            return None;
        }
        // The GPS tells of its height once a second: while the vehicle climbs that is another one.
        let climbs = odometry.velocity_mps[2].abs() > SLOW_MPS;
        if climbs || (self.checked && !self.doubted) {
            return None;
        }
        self.checked = true;
        // Out of doubt at half of it, so that noise does not make it chatter.
        let limit_mm = if self.doubted { self.limit_mm / 2 } else { self.limit_mm };
        let doubt = self.doubt(state, odometry.alt_mm, home_mm, limit_mm);
        if doubt.is_some() == self.doubted {
            return None;
        }
        self.doubted = doubt.is_some();
        Some(doubt.map_or_else(
            || Notice::info("the heights by the estimator and by the GPS agree again"),
            |doubt| Notice::warning(format!("{doubt}; `start` flies all the same")),
        ))
    }

    /// What is wrong with the height, in words.
    fn doubt(&self, state: &VehicleState, alt_mm: i32, home_mm: i32, limit_mm: u32) -> Option<String> {
        let metres = |mm: i32| f64::from(mm) / 1000.0;
        let limit_m = f64::from(self.limit_mm) / 1000.0;
        let has_fix = state.gps_fix.is_some_and(|(fix, _)| fix >= LEAST_FIX);
        if let Some(gps_mm) = state.gps_alt_mm.filter(|mm| has_fix && mm.abs_diff(alt_mm) > limit_mm) {
            return Some(format!(
                "the height is in doubt: {:.1} m above sea level by the estimator, {:.1} m by the GPS; they may differ by \
                 {limit_m} m (altitude.check_m)",
                metres(alt_mm),
                metres(gps_mm)
            ));
        }
        let before_mm = self.home_mm.filter(|mm| mm.abs_diff(home_mm) > limit_mm)?;
        Some(format!(
            "the height is in doubt: home was {:.1} m above sea level before the climb and is {:.1} m now; it may change \
             by {limit_m} m (altitude.check_m)",
            metres(before_mm),
            metres(home_mm)
        ))
    }
}
