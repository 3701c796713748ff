//! What is known of the vehicle: its measured state in the swarm's frame, its clock, its health.

use super::clock::{Tick, VehicleClock};
use super::telemetry::{GlobalPosition, Heartbeat, LocalPosition, Telemetry};
use crate::mission::{Place, Plane};

/// LOCAL_POSITION_NED is taken for the finer form of the same position when it differs from
/// GLOBAL_POSITION_INT by no more than this on each axis, mm: the latter's grain is 11 mm.
const SAME_MM: f64 = 50.0;
/// The two disagree when they differ by more than this, mm …
const DISAGREE_MM: f64 = 1000.0;
/// … and this share of the distance from the estimator's origin: autopilots scale degrees
/// differently.
const DISAGREE_SHARE: f64 = 0.01;
/// No UAV is higher or deeper, mm: also keeps sums of altitudes within 32 bits.
const HIGHEST_MM: u32 = 100_000_000;
/// Two messages of times no farther apart than this tell of the same moment, ms: an autopilot
/// stamps each as it is sent.
const SAME_MS: u32 = 5;
/// After so many positions without a LOCAL_POSITION_NED of the same time none is waited for.
const PATIENCE: u8 = 3;

/// A measured state in the mission's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fix {
    /// When it was measured, vehicle's clock.
    pub boot_ms: u32,
    /// Position.
    pub place: Place,
    /// Altitude above mean sea level and above home, mm.
    pub alt_mm: i32,
    /// See `alt_mm`.
    pub relative_mm: i32,
    /// Velocity east, north and up, m/s.
    pub velocity_mps: [f64; 3],
    /// Whether it has LOCAL_POSITION_NED's precision.
    pub fine: bool,
}

/// What a message changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Nothing that calls for an answer.
    Noted,
    /// A new [`Fix`] is complete.
    Fix,
    /// The vehicle's clock started anew.
    Restarted,
    /// The common clock moved by so many ms.
    ClockMoved(i64),
}

/// The vehicle as its messages tell.
#[derive(Clone, Debug)]
pub struct Vehicle {
    plane: Plane,
    /// Its clock.
    pub clock: VehicleClock,
    /// The last heartbeat and the vehicle's time when it came.
    pub heartbeat: Option<(Heartbeat, u32)>,
    /// The newest complete state.
    pub fix: Option<Fix>,
    /// A global position that waits for its local one.
    pending: Option<Fix>,
    /// A local position that came first.
    early: Option<LocalPosition>,
    since_local: u8,
    /// Where the estimator has its origin.
    origin: Option<Place>,
    /// Numbers that cannot be used came since this was last taken.
    refused: bool,
    /// The two positions disagree.
    pub sources_disagree: bool,
    /// The estimator's last word and the vehicle's time when it came.
    pub estimator: Option<(bool, u32)>,
    /// The last kind of GPS fix and the vehicle's time when it came.
    pub gps_fix: Option<(u8, u32)>,
    /// Charge left, percent.
    pub battery: Option<u8>,
    /// Whether the autopilot says that it stands on the ground.
    pub on_ground: Option<bool>,
}

impl Vehicle {
    /// Nothing is known yet; positions will be told on this plane.
    #[must_use]
    pub fn new(plane: Plane) -> Self {
        Self {
            plane,
            clock: VehicleClock::default(),
            heartbeat: None,
            fix: None,
            pending: None,
            early: None,
            since_local: 0,
            origin: None,
            refused: false,
            sources_disagree: false,
            estimator: None,
            gps_fix: None,
            battery: None,
            on_ground: None,
        }
    }

    /// Takes in a message.
    pub fn hear(&mut self, telemetry: &Telemetry) -> Heard {
        let now = self.clock.newest().unwrap_or(0);
        match *telemetry {
            Telemetry::Heartbeat(heartbeat) => self.heartbeat = Some((heartbeat, now)),
            Telemetry::Battery(percent) => self.battery = percent.or(self.battery),
            Telemetry::GpsFix(kind) => self.gps_fix = Some((kind, now)),
            Telemetry::Estimator { healthy } => self.estimator = Some((healthy, now)),
            Telemetry::OnGround(on_ground) => self.on_ground = on_ground,
            Telemetry::Origin { lat_e7, lon_e7 } => self.origin = self.plane.place(lat_e7, lon_e7),
            Telemetry::SystemTime { unix_us, boot_ms } => return self.hear_time(unix_us, boot_ms),
            Telemetry::Global(ref global) => return self.hear_global(global),
            Telemetry::Local(ref local) => return self.hear_local(local),
            Telemetry::Ack { .. } | Telemetry::Text { .. } => {}
        }
        Heard::Noted
    }

    /// Whether a number that cannot be used came since this was last asked.
    pub const fn take_refused(&mut self) -> bool {
        std::mem::replace(&mut self.refused, false)
    }

    /// The vehicle's time now: the newest heard.
    #[must_use]
    pub fn now_ms(&self) -> u32 {
        self.clock.newest().unwrap_or(0)
    }

    fn hear_time(&mut self, unix_us: u64, boot_ms: u32) -> Heard {
        let tick = self.tick(boot_ms);
        // Zero until the autopilot has it from its GPS.
        let unix_ms = i64::try_from(unix_us / 1000).unwrap_or(0);
        if unix_ms > 0
            && let Some(moved) = self.clock.set_unix(unix_ms, boot_ms)
        {
            return Heard::ClockMoved(moved);
        }
        if tick == Tick::Restarted { Heard::Restarted } else { Heard::Noted }
    }

    fn hear_global(&mut self, global: &GlobalPosition) -> Heard {
        let tick = self.tick(global.boot_ms);
        if tick == Tick::Older {
            return Heard::Noted;
        }
        let done = |heard| if tick == Tick::Restarted { Heard::Restarted } else { heard };
        let sane = [global.alt_mm, global.relative_mm].iter().all(|mm| mm.unsigned_abs() <= HIGHEST_MM);
        let Some(place) = self.plane.place(global.lat_e7, global.lon_e7).filter(|_| sane) else {
            self.refused = true;
            return done(Heard::Noted);
        };
        let [north, east, down] = global.velocity_cmps.map(|v| f64::from(v) / 100.0);
        let mut fix = Fix {
            boot_ms: global.boot_ms,
            place,
            alt_mm: global.alt_mm,
            relative_mm: global.relative_mm,
            velocity_mps: [east, north, -down],
            fine: false,
        };
        if let Some(local) = self.early.take().filter(|local| is_same_time(local.boot_ms, global.boot_ms)) {
            self.since_local = 0;
            self.refine(&mut fix, &local);
            (self.fix, self.pending) = (Some(fix), None);
            return done(Heard::Fix);
        }
        if self.since_local < PATIENCE {
            // A pair that lost its second half still counts, with the next one.
            self.since_local += u8::from(self.pending.is_some());
            self.pending = Some(fix);
            return done(Heard::Noted);
        }
        self.fix = Some(fix);
        // Should the local one come after all, the next pair is waited for again.
        self.pending = Some(fix);
        done(Heard::Fix)
    }

    fn hear_local(&mut self, local: &LocalPosition) -> Heard {
        let tick = self.tick(local.boot_ms);
        if !local.is_finite() {
            self.refused = true;
        }
        let pending = self.pending.take_if(|fix| is_same_time(fix.boot_ms, local.boot_ms));
        let Some(mut fix) = pending else {
            self.early = Some(*local);
            return if tick == Tick::Restarted { Heard::Restarted } else { Heard::Noted };
        };
        let waited_for = self.since_local < PATIENCE;
        self.since_local = 0;
        self.refine(&mut fix, local);
        if waited_for {
            self.fix = Some(fix);
            return Heard::Fix;
        }
        Heard::Noted
    }

    /// Takes the finer numbers where they say the same.
    fn refine(&mut self, fix: &mut Fix, local: &LocalPosition) {
        if !local.is_finite() {
            return;
        }
        let [north, east, _] = local.position_m.map(|m| f64::from(m) * 1000.0);
        let [v_north, v_east, v_down] = local.velocity_mps.map(f64::from);
        fix.velocity_mps = [v_east, v_north, -v_down];
        let Some(origin) = self.origin else { return };
        let place = Place { east_mm: origin.east_mm + east, north_mm: origin.north_mm + north };
        let apart = (place.east_mm - fix.place.east_mm).abs().max((place.north_mm - fix.place.north_mm).abs());
        self.sources_disagree = apart > DISAGREE_MM + DISAGREE_SHARE * north.hypot(east);
        if apart <= SAME_MM {
            (fix.place, fix.fine) = (place, true);
        }
    }

    fn tick(&mut self, boot_ms: u32) -> Tick {
        let tick = self.clock.hear(boot_ms);
        if tick == Tick::Restarted {
            // What another boot said is of no use.
            let clock = self.clock;
            let heartbeat = self.heartbeat.map(|(heartbeat, _)| (heartbeat, boot_ms));
            *self = Self { clock, heartbeat, ..Self::new(self.plane) };
        }
        tick
    }
}

const fn is_same_time(a: u32, b: u32) -> bool {
    (a.wrapping_sub(b) as i32).unsigned_abs() <= SAME_MS
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn with_origin() -> Vehicle {
        let mut vehicle = Vehicle::new(plane());
        let (lat_e7, lon_e7) = plane().degrees_e7(Place { east_mm: 50_000.0, north_mm: -20_000.0 });
        vehicle.hear(&Telemetry::Origin { lat_e7, lon_e7 });
        vehicle
    }

    #[test]
    fn a_pair_of_the_same_time_gives_the_finer_position() {
        let mut vehicle = with_origin();
        let at = Place { east_mm: 150_000.0, north_mm: 80_000.0 };
        assert_eq!(vehicle.hear(&global(1000, at)), Heard::Noted);
        assert_eq!(vehicle.hear(&local(1000, 100.003, 100.001)), Heard::Fix);
        let fix = vehicle.fix.unwrap();
        assert!(fix.fine && !vehicle.sources_disagree);
        // The origin's own degrees are rounded: 5.6 mm.
        assert!((fix.place.north_mm - 80_003.0).abs() < 6.0 && (fix.place.east_mm - 150_001.0).abs() < 6.0);
        assert!((fix.velocity_mps[0] - 2.002).abs() < 1e-6 && fix.velocity_mps[2] == 0.5);
    }

    #[test]
    fn the_local_position_may_come_first_and_a_little_earlier() {
        let mut vehicle = with_origin();
        let at = Place { east_mm: 150_000.0, north_mm: 80_000.0 };
        assert_eq!(vehicle.hear(&local(998, 100.003, 100.001)), Heard::Noted);
        assert_eq!(vehicle.hear(&global(1000, at)), Heard::Fix);
        assert!(vehicle.fix.unwrap().fine && vehicle.fix.unwrap().boot_ms == 1000);
        // Once it is too early it is no pair.
        assert_eq!(vehicle.hear(&local(1190, 100.0, 100.0)), Heard::Noted);
        assert_eq!(vehicle.hear(&global(1200, at)), Heard::Noted);
    }

    #[test]
    fn positions_that_disagree_are_told_and_the_common_one_is_taken() {
        let mut vehicle = with_origin();
        let at = Place { east_mm: 150_000.0, north_mm: 80_000.0 };
        vehicle.hear(&global(1000, at));
        assert_eq!(vehicle.hear(&local(1000, 104.0, 100.0)), Heard::Fix);
        assert!(vehicle.sources_disagree && !vehicle.fix.unwrap().fine);
        vehicle.hear(&global(1200, at));
        vehicle.hear(&local(1200, 100.5, 100.0));
        assert!(!vehicle.sources_disagree && !vehicle.fix.unwrap().fine);
    }

    #[test]
    fn without_a_local_position_the_global_one_does_after_a_while() {
        let mut vehicle = Vehicle::new(plane());
        let heard: Vec<_> = (0..6).map(|i| vehicle.hear(&global(i * 200, Place::default()))).collect();
        assert_eq!(heard[..4], [Heard::Noted; 4]);
        assert_eq!(heard[4..], [Heard::Fix; 2]);
        // It comes back: one answer to a pair again.
        assert_eq!(vehicle.hear(&local(1000, 0.0, 0.0)), Heard::Noted);
        assert_eq!(vehicle.hear(&global(1200, Place::default())), Heard::Noted);
        assert_eq!(vehicle.hear(&local(1200, 0.0, 0.0)), Heard::Fix);
    }

    #[test]
    fn numbers_that_are_none_are_refused_once() {
        let mut vehicle = with_origin();
        vehicle.hear(&global(1000, Place::default()));
        assert_eq!(vehicle.hear(&local(1000, f32::NAN, 0.0)), Heard::Fix);
        assert!(vehicle.take_refused() && !vehicle.take_refused());
        let mut far = global(1200, Place::default());
        if let Telemetry::Global(g) = &mut far {
            g.lat_e7 = 0;
        }
        assert_eq!(vehicle.hear(&far), Heard::Noted);
        assert!(vehicle.take_refused());
    }

    #[test]
    fn a_reboot_forgets_what_was_measured_before() {
        let mut vehicle = with_origin();
        vehicle.hear(&global(100_000, Place::default()));
        vehicle.hear(&local(100_000, 20.0, -50.0));
        assert_eq!(vehicle.hear(&global(300, Place::default())), Heard::Restarted);
        assert_eq!(vehicle.fix, None);
    }
}
