//! The state of a vehicle by its telemetry: odometry, clocks, health.

use super::batteries::Batteries;
use super::clock::{ClockUpdate, VehicleClock};
use super::firmware::{Firmware, Mode};
use super::odometry::{Odometry, PositionPairing};
use super::shared_id::{Senders, SharedId};
use crate::messages::{GlobalPosition, Heartbeat, LocalPosition, Telemetry};
use crate::mission::Plane;

/// Altitudes beyond this are refused as invalid, mm; it also keeps sums of altitudes within 32 bits.
const HIGHEST_MM: u32 = 100_000_000;
/// Unix time before 2020 is that of a clock that was never set, ms.
const UNSET_BEFORE_MS: i64 = 1_577_836_800_000;

/// What a message changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TelemetryUpdate {
    /// A new [`Odometry`] is complete.
    Odometry,
    /// The vehicle rebooted, or its boot clock jumped.
    Rebooted,
    /// The common clock was corrected by so many ms.
    ClockCorrected(i64),
    /// Unix time began to run at another rate than the vehicle's clock, or stopped doing so: its rate in
    /// thousandths.
    ClockRate(i64),
    /// Anything else.
    Other,
}

/// The state of a vehicle by its telemetry.
#[derive(Clone, Debug)]
pub struct VehicleState {
    plane: Plane,
    shared_id: SharedId,
    /// The vehicle's boot clock and the common clock.
    pub clock: VehicleClock,
    /// The last HEARTBEAT and the `time_boot_ms` when it arrived.
    pub heartbeat: Option<(Heartbeat, u32)>,
    /// The newest complete odometry.
    pub odometry: Option<Odometry>,
    positions: PositionPairing,
    /// An invalid position or altitude arrived since [`Self::take_invalid`] was last called.
    invalid: bool,
    /// Whether the estimator was healthy in its last report, and the `time_boot_ms` when it arrived.
    pub estimator: Option<(bool, u32)>,
    /// The last GPS_FIX_TYPE and the `time_boot_ms` when it arrived.
    pub gps_fix: Option<(u8, u32)>,
    batteries: Batteries,
    /// Altitude above mean sea level in the last GPS_RAW_INT, mm.
    pub gps_alt_mm: Option<i32>,
    /// The last position, where it lies beyond the plane: latitude and longitude, 1e-7 degrees.
    pub beyond: Option<(i32, i32)>,
    /// Whether the vehicle is landed, by EXTENDED_SYS_STATE.
    pub on_ground: Option<bool>,
}

impl VehicleState {
    /// The state before any telemetry. Positions will be given on this plane.
    #[must_use]
    pub fn new(plane: Plane) -> Self {
        Self {
            plane,
            shared_id: SharedId::default(),
            clock: VehicleClock::default(),
            heartbeat: None,
            odometry: None,
            positions: PositionPairing::default(),
            invalid: false,
            estimator: None,
            gps_fix: None,
            batteries: Batteries::default(),
            gps_alt_mm: None,
            beyond: None,
            on_ground: None,
        }
    }

    /// Takes in a message.
    pub fn update(&mut self, telemetry: &Telemetry) -> TelemetryUpdate {
        let now = self.now_ms();
        match *telemetry {
            Telemetry::Heartbeat(heartbeat) => self.heartbeat = Some((heartbeat, now)),
            Telemetry::Charge(percent) => self.batteries.take_summary(percent, now),
            Telemetry::Battery(ref battery) => self.batteries.take(battery, now),
            Telemetry::Gps { fix, alt_mm } => (self.gps_fix, self.gps_alt_mm) = (Some((fix, now)), alt_mm),
            Telemetry::Estimator { healthy } => self.estimator = Some((healthy, now)),
            Telemetry::OnGround(on_ground) => self.on_ground = on_ground,
            Telemetry::Origin { lat_e7, lon_e7 } => self.positions.set_origin(self.plane.place(lat_e7, lon_e7)),
            Telemetry::SystemTime { unix_us, boot_ms } => return self.system_time(unix_us, boot_ms),
            Telemetry::Global(ref global) => return self.global_position(global),
            Telemetry::Local(ref local) => return self.local_position(local),
            Telemetry::Ack { .. } | Telemetry::Text { .. } | Telemetry::Parameter(_) => {}
        }
        TelemetryUpdate::Other
    }

    /// The flight mode in the last HEARTBEAT, for an autopilot of this firmware.
    #[must_use]
    pub fn mode(&self, firmware: Firmware) -> Option<Mode> {
        Some(firmware.mode(self.heartbeat?.0.custom_mode))
    }

    /// The name of that mode, as users know it; `unknown` before the first HEARTBEAT.
    #[must_use]
    pub fn mode_name(&self, firmware: Firmware) -> String {
        self.heartbeat.map_or_else(|| "unknown".into(), |(heartbeat, _)| firmware.mode_name(heartbeat.custom_mode))
    }

    /// Whether the vehicle was armed in the last HEARTBEAT.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.heartbeat.is_some_and(|(heartbeat, _)| heartbeat.armed)
    }

    /// The lowest remaining charge of a flight battery, percent.
    #[must_use]
    pub fn battery_percent(&self) -> Option<u8> {
        self.batteries.lowest(self.now_ms())
    }

    /// Whether GLOBAL_POSITION_INT and LOCAL_POSITION_NED disagreed when last compared.
    #[must_use]
    pub const fn sources_disagree(&self) -> bool {
        self.positions.disagree()
    }

    /// Whether an invalid number (NaN, infinite, or out of any vehicle's range) arrived since this was
    /// last called.
    pub const fn take_invalid(&mut self) -> bool {
        std::mem::replace(&mut self.invalid, false)
    }

    /// The newest `time_boot_ms`; 0 before the first.
    #[must_use]
    pub fn now_ms(&self) -> u32 {
        self.clock.newest().unwrap_or(0)
    }

    /// Whether one vehicle sends with its system id, or two.
    pub(super) const fn senders(&self) -> Senders {
        self.shared_id.senders()
    }

    /// Forgets that two vehicles were heard.
    pub(super) fn forget_senders(&mut self) {
        self.shared_id = SharedId::default();
    }

    /// What a start still waits for, in words.
    pub(crate) fn missing(&self) -> Option<&'static str> {
        if self.odometry.is_none() {
            Some("a position near the mission's origin")
        } else if self.estimator.is_none_or(|(healthy, _)| !healthy) {
            Some("the estimator to trust its position")
        } else if self.gps_fix.is_some_and(|(kind, _)| kind < 3) {
            Some("a 3D GPS fix")
        } else if self.clock.is_drifting() {
            Some("a Unix time that runs as fast as the vehicle's clock")
        } else if !self.clock.is_set() {
            Some("the time (SYSTEM_TIME)")
        } else {
            None
        }
    }

    fn system_time(&mut self, unix_us: u64, boot_ms: u32) -> TelemetryUpdate {
        let clock = self.update_clock(boot_ms);
        // Zero, or 1970, until the autopilot has it from its GPS.
        let unix_ms = i64::try_from(unix_us / 1000).unwrap_or(0);
        if unix_ms >= UNSET_BEFORE_MS && clock != ClockUpdate::Reordered {
            if let Some(permille) = self.clock.check_rate(unix_ms, boot_ms) {
                return TelemetryUpdate::ClockRate(permille);
            }
            if let Some(moved) = self.clock.set_unix(unix_ms, boot_ms) {
                return TelemetryUpdate::ClockCorrected(moved);
            }
        }
        if clock == ClockUpdate::Restarted { TelemetryUpdate::Rebooted } else { TelemetryUpdate::Other }
    }

    fn global_position(&mut self, global: &GlobalPosition) -> TelemetryUpdate {
        let clock = self.update_clock(global.boot_ms);
        if clock == ClockUpdate::Reordered {
            return TelemetryUpdate::Other;
        }
        let sane = [global.alt_mm, global.relative_mm].iter().all(|mm| mm.unsigned_abs() <= HIGHEST_MM);
        let place = self.plane.place(global.lat_e7, global.lon_e7);
        self.beyond = place.is_none().then_some((global.lat_e7, global.lon_e7));
        let complete = match place.filter(|_| sane) {
            Some(place) => self.positions.add_global(Odometry::coarse(global, place)),
            None => {
                self.invalid = true;
                None
            }
        };
        self.finish(clock, complete)
    }

    fn local_position(&mut self, local: &LocalPosition) -> TelemetryUpdate {
        let clock = self.update_clock(local.boot_ms);
        self.invalid |= !local.is_finite();
        let complete = self.positions.add_local(local);
        self.finish(clock, complete)
    }

    fn finish(&mut self, clock: ClockUpdate, complete: Option<Odometry>) -> TelemetryUpdate {
        let is_complete = complete.is_some();
        self.odometry = complete.or(self.odometry);
        match (clock, is_complete) {
            (ClockUpdate::Restarted, _) => TelemetryUpdate::Rebooted,
            (_, true) => TelemetryUpdate::Odometry,
            (_, false) => TelemetryUpdate::Other,
        }
    }

    fn update_clock(&mut self, boot_ms: u32) -> ClockUpdate {
        let update = self.clock.update(boot_ms);
        self.shared_id.update(update);
        if update == ClockUpdate::Restarted {
            // Nothing that was measured before the reboot holds any more.
            let (clock, shared_id) = (self.clock, self.shared_id);
            let heartbeat = self.heartbeat.map(|(heartbeat, _)| (heartbeat, boot_ms));
            *self = Self { clock, shared_id, heartbeat, ..Self::new(self.plane) };
        }
        update
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mission::Place;

    fn plane() -> Plane {
        Plane::new(47.4, 8.5, 400.0).unwrap()
    }

    fn global(boot_ms: u32, place: Place) -> Telemetry {
        let (lat_e7, lon_e7) = plane().degrees_e7(place);
        let velocity_cmps = [100, 200, -50];
        Telemetry::Global(GlobalPosition {
            boot_ms,
            lat_e7,
            lon_e7,
            alt_mm: 420_000,
            relative_mm: 20_000,
            velocity_cmps,
        })
    }

    fn local(boot_ms: u32, north_m: f32, east_m: f32) -> Telemetry {
        let position_m = [north_m, east_m, -20.0];
        Telemetry::Local(LocalPosition { boot_ms, position_m, velocity_mps: [1.001, 2.002, -0.5] })
    }

    fn with_origin() -> VehicleState {
        let mut vehicle = VehicleState::new(plane());
        let (lat_e7, lon_e7) = plane().degrees_e7(Place { east_mm: 50_000.0, north_mm: -20_000.0 });
        vehicle.update(&Telemetry::Origin { lat_e7, lon_e7 });
        vehicle
    }

    #[test]
    fn a_pair_of_the_same_time_gives_the_finer_position() {
        let mut vehicle = with_origin();
        let at = Place { east_mm: 150_000.0, north_mm: 80_000.0 };
        assert_eq!(vehicle.update(&global(1000, at)), TelemetryUpdate::Other);
        assert_eq!(vehicle.update(&local(1000, 100.003, 100.001)), TelemetryUpdate::Odometry);
        let odometry = vehicle.odometry.unwrap();
        assert!(odometry.fine && !vehicle.sources_disagree());
        // The origin's own degrees are rounded: 5.6 mm.
        assert!((odometry.place.north_mm - 80_003.0).abs() < 6.0 && (odometry.place.east_mm - 150_001.0).abs() < 6.0);
        assert!((odometry.velocity_mps[0] - 2.002).abs() < 1e-6 && odometry.velocity_mps[2] == 0.5);
    }

    #[test]
    fn the_local_position_may_come_first_and_a_little_earlier() {
        let mut vehicle = with_origin();
        let at = Place { east_mm: 150_000.0, north_mm: 80_000.0 };
        assert_eq!(vehicle.update(&local(998, 100.003, 100.001)), TelemetryUpdate::Other);
        assert_eq!(vehicle.update(&global(1000, at)), TelemetryUpdate::Odometry);
        assert!(vehicle.odometry.unwrap().fine && vehicle.odometry.unwrap().boot_ms == 1000);
        // Once it is too early it is no pair.
        assert_eq!(vehicle.update(&local(1190, 100.0, 100.0)), TelemetryUpdate::Other);
        assert_eq!(vehicle.update(&global(1200, at)), TelemetryUpdate::Other);
    }

    #[test]
    fn positions_that_disagree_are_told_and_the_common_one_is_taken() {
        let mut vehicle = with_origin();
        let at = Place { east_mm: 150_000.0, north_mm: 80_000.0 };
        vehicle.update(&global(1000, at));
        assert_eq!(vehicle.update(&local(1000, 104.0, 100.0)), TelemetryUpdate::Odometry);
        assert!(vehicle.sources_disagree() && !vehicle.odometry.unwrap().fine);
        vehicle.update(&global(1200, at));
        vehicle.update(&local(1200, 100.5, 100.0));
        assert!(!vehicle.sources_disagree() && !vehicle.odometry.unwrap().fine);
    }

    #[test]
    fn without_a_local_position_the_global_one_does_after_a_while() {
        let mut vehicle = VehicleState::new(plane());
        let heard: Vec<_> = (0..6).map(|i| vehicle.update(&global(i * 200, Place::default()))).collect();
        assert_eq!(heard[..4], [TelemetryUpdate::Other; 4]);
        assert_eq!(heard[4..], [TelemetryUpdate::Odometry; 2]);
        // It comes back: one answer to a pair again.
        assert_eq!(vehicle.update(&local(1000, 0.0, 0.0)), TelemetryUpdate::Other);
        assert_eq!(vehicle.update(&global(1200, Place::default())), TelemetryUpdate::Other);
        assert_eq!(vehicle.update(&local(1200, 0.0, 0.0)), TelemetryUpdate::Odometry);
    }

    #[test]
    fn a_local_position_that_always_comes_a_little_earlier_is_moved_on_by_its_velocity() {
        let mut vehicle = with_origin();
        let heard: Vec<_> = (0..8)
            .map(|i| {
                // 1 m/s north and 2 m/s east; the local one is 36 ms older.
                let (north_m, east_m) = (100.0 + 0.2 * i as f32, 100.0 + 0.4 * i as f32);
                vehicle.update(&local(1000 + i * 200, north_m - 0.036, east_m - 0.072));
                let at = Place {
                    east_mm: 50_000.0 + f64::from(east_m) * 1000.0,
                    north_mm: -20_000.0 + f64::from(north_m) * 1000.0,
                };
                let update = vehicle.update(&global(1036 + i * 200, at));
                (update, vehicle.odometry.map(|o| (o.fine, o.boot_ms, (o.place.east_mm - at.east_mm).abs() < 6.0)))
            })
            .collect();
        assert!(heard[4..].iter().all(|(update, _)| *update == TelemetryUpdate::Odometry), "{heard:?}");
        assert_eq!(heard[7].1, Some((true, 1036 + 1400, true)));
        // Its velocity is of another time: that of the global one counts.
        assert_eq!(vehicle.odometry.unwrap().velocity_mps, [2.0, 1.0, 0.5]);
    }

    #[test]
    fn unix_time_that_was_never_set_is_not_believed() {
        let mut vehicle = with_origin();
        for unix_us in [0, 5_000_000, 1_500_000_000_000_000] {
            vehicle.update(&Telemetry::SystemTime { unix_us, boot_ms: 1000 });
            assert!(!vehicle.clock.is_set(), "{unix_us}");
        }
        vehicle.update(&Telemetry::SystemTime { unix_us: 1_790_000_000_000_000, boot_ms: 1200 });
        assert!(vehicle.clock.is_set());
    }

    #[test]
    fn numbers_that_are_none_are_refused_once() {
        let mut vehicle = with_origin();
        vehicle.update(&global(1000, Place::default()));
        assert_eq!(vehicle.update(&local(1000, f32::NAN, 0.0)), TelemetryUpdate::Odometry);
        assert!(vehicle.take_invalid() && !vehicle.take_invalid());
        let mut far = global(1200, Place::default());
        if let Telemetry::Global(g) = &mut far {
            g.lat_e7 = 0;
        }
        assert_eq!(vehicle.update(&far), TelemetryUpdate::Other);
        assert!(vehicle.take_invalid());
    }

    #[test]
    fn a_reboot_forgets_what_was_measured_before() {
        let mut vehicle = with_origin();
        vehicle.update(&global(100_000, Place::default()));
        vehicle.update(&local(100_000, 20.0, -50.0));
        assert_eq!(vehicle.update(&global(300, Place::default())), TelemetryUpdate::Rebooted);
        assert_eq!(vehicle.odometry, None);
    }
}
