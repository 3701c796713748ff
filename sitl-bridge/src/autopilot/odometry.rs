//! Position and velocity from GLOBAL_POSITION_INT and LOCAL_POSITION_NED.
//!
//! The global position is in the frame that all UAVs share, with a grain of 11 mm. The local position
//! has the precision of a float, relative to the estimator's own origin. Where both are of the same
//! time and agree, the local one refines the global one. ArduPilot sends them in the same millisecond.
//! PX4 sends them 32 to 40 ms apart: there the last local position is moved on by its velocity.

use crate::messages::{GlobalPosition, LocalPosition};
use crate::mission::Place;

/// LOCAL_POSITION_NED refines GLOBAL_POSITION_INT when they differ by no more than this on each axis,
/// mm: the latter's grain is 11 mm.
const SAME_MM: f64 = 50.0;
/// The two disagree when they differ by more than this, mm …
const DISAGREE_MM: f64 = 1000.0;
/// … and this share of the distance from the estimator's origin: autopilots scale degrees
/// differently.
const DISAGREE_SHARE: f64 = 0.01;
/// Two messages with times no farther apart than this belong to the same sample, ms: an autopilot
/// stamps each as it is sent.
const SAME_MS: u32 = 5;
/// Where no times are the same, a local position may be this much older, ms: within that time 3 m/s² of
/// acceleration change what is moved on by velocity by 8 mm.
const NEAR_MS: u32 = 75;
/// After so many GLOBAL_POSITION_INT without a LOCAL_POSITION_NED of the same time it is no longer
/// waited for.
const MAX_UNPAIRED: u8 = 3;

/// A measured position and velocity in the mission's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odometry {
    /// `time_boot_ms` of the measurement.
    pub boot_ms: u32,
    /// Horizontal position.
    pub place: Place,
    /// Altitude above mean sea level, mm.
    pub alt_mm: i32,
    /// Altitude above home, mm.
    pub relative_mm: i32,
    /// Velocity east, north and up, m/s.
    pub velocity_mps: [f64; 3],
    /// Whether the position has the precision of LOCAL_POSITION_NED.
    pub fine: bool,
}

impl Odometry {
    /// The odometry of a GLOBAL_POSITION_INT at `place`.
    pub(super) fn coarse(global: &GlobalPosition, place: Place) -> Self {
        let [north, east, down] = global.velocity_cmps.map(|v| f64::from(v) / 100.0);
        Self {
            boot_ms: global.boot_ms,
            place,
            alt_mm: global.alt_mm,
            relative_mm: global.relative_mm,
            velocity_mps: [east, north, -down],
            fine: false,
        }
    }
}

/// Pairs global and local positions of the same time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PositionPairing {
    /// A global position that waits for its local one.
    pending: Option<Odometry>,
    /// The last local position that did not complete a global one.
    early: Option<LocalPosition>,
    /// Global positions without a local one since the last pair.
    unpaired: u8,
    /// The estimator's origin, by GPS_GLOBAL_ORIGIN.
    origin: Option<Place>,
    disagree: bool,
}

impl PositionPairing {
    /// Sets the origin of LOCAL_POSITION_NED; `None` when it is too far away.
    pub const fn set_origin(&mut self, origin: Option<Place>) {
        self.origin = origin;
    }

    /// Whether the two positions disagreed when last compared.
    pub const fn disagree(&self) -> bool {
        self.disagree
    }

    /// Adds a global position; returns the odometry if it is complete.
    pub fn add_global(&mut self, mut odometry: Odometry) -> Option<Odometry> {
        let early = self.early.take();
        if let Some(local) = early.filter(|local| is_same_time(local.boot_ms, odometry.boot_ms)) {
            self.unpaired = 0;
            self.pending = None;
            self.refine(&mut odometry, &local);
            return Some(odometry);
        }
        let older_ms = |local: &LocalPosition| odometry.boot_ms.wrapping_sub(local.boot_ms);
        let near = early.filter(|local| older_ms(local) <= NEAR_MS);
        let waits = self.unpaired < MAX_UNPAIRED;
        if waits {
            // The one that still waits never got its local position.
            self.unpaired += u8::from(self.pending.is_some());
        } else if let Some(local) = near {
            self.refine(&mut odometry, &local);
        }
        // Also when it is not waited for: a local position that comes after all begins pairing again.
        self.pending = Some(odometry);
        (!waits).then_some(odometry)
    }

    /// Adds a local position; returns the odometry if it is complete with it.
    pub fn add_local(&mut self, local: &LocalPosition) -> Option<Odometry> {
        let Some(mut odometry) = self.pending.take_if(|global| is_same_time(global.boot_ms, local.boot_ms)) else {
            self.early = Some(*local);
            return None;
        };
        let waited_for = self.unpaired < MAX_UNPAIRED;
        self.unpaired = 0;
        self.refine(&mut odometry, local);
        waited_for.then_some(odometry)
    }

    /// Takes over the local position where it agrees, moved on to the time of the global one, and the local
    /// velocity where it is of the same time.
    fn refine(&mut self, odometry: &mut Odometry, local: &LocalPosition) {
        if !local.is_finite() {
            return;
        }
        let [v_north, v_east, v_down] = local.velocity_mps.map(f64::from);
        if is_same_time(local.boot_ms, odometry.boot_ms) {
            odometry.velocity_mps = [v_east, v_north, -v_down];
        }
        // Metres per second are millimetres per millisecond.
        let later_ms = f64::from(odometry.boot_ms.wrapping_sub(local.boot_ms) as i32);
        let [north, east, _] = local.position_m.map(|m| f64::from(m) * 1000.0);
        let (north, east) = (north + v_north * later_ms, east + v_east * later_ms);
        let Some(origin) = self.origin else { return };
        let place = Place { east_mm: origin.east_mm + east, north_mm: origin.north_mm + north };
        let global = odometry.place;
        let apart = (place.east_mm - global.east_mm).abs().max((place.north_mm - global.north_mm).abs());
        self.disagree = apart > DISAGREE_MM + DISAGREE_SHARE * north.hypot(east);
        if apart <= SAME_MM {
            (odometry.place, odometry.fine) = (place, true);
        }
    }
}

const fn is_same_time(a: u32, b: u32) -> bool {
    (a.wrapping_sub(b) as i32).unsigned_abs() <= SAME_MS
}
