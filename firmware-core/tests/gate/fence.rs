//! The fence: which shapes it takes, what is inside, and that no vehicle crosses it whatever the actor wants.

use firmware_core::gate::{
    Circle, FlightMode, Gate, Geofence, GeofenceError, Inputs, Limits, LimitsError, MAX_CORNERS, Measured, Proposal,
    Reason, Request, Vector, Verdict,
};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn square(side_mm: i32) -> Geofence {
    Geofence::rectangle(Vector::ZERO, Vector::new(side_mm, side_mm)).unwrap()
}

fn polygon(corners: &[(i32, i32)]) -> Result<Geofence, GeofenceError> {
    let corners: Vec<Vector> = corners.iter().map(|c| Vector::new(c.0, c.1)).collect();
    Geofence::polygon(&corners)
}

/// An L, counter-clockwise.
const L_SHAPE: [(i32, i32); 6] =
    [(0, 0), (90_000, 0), (90_000, 40_000), (40_000, 40_000), (40_000, 90_000), (0, 90_000)];

#[test]
fn shapes_that_are_none_are_refused() {
    assert_eq!(polygon(&[(0, 0), (1, 1)]), Err(GeofenceError::Corners(2)));
    let many: Vec<(i32, i32)> = (0..=MAX_CORNERS as i32).map(|i| (i * 1000, i * i * 1000)).collect();
    assert_eq!(polygon(&many), Err(GeofenceError::Corners(17)));
    assert_eq!(polygon(&[(0, 0), (9000, 0), (9000, 0), (0, 9000)]), Err(GeofenceError::SamePoint(1)));
    assert_eq!(polygon(&[(0, 0), (9000, 9000), (9000, 0), (0, 9000)]), Err(GeofenceError::Crossing(0, 2)));
    assert_eq!(polygon(&[(0, 0), (90_000, 1000), (90_000, 9000)]), Err(GeofenceError::TooSharp(0)));
    assert_eq!(polygon(&[(90_000, 9000), (90_000, 1000), (0, 0)]), Err(GeofenceError::TooSharp(2)));
    assert_eq!(polygon(&[(0, 0), (90_000, 0), (40_000, 0)]), Err(GeofenceError::TooSharp(1)));
    assert_eq!(polygon(&[(0, 0), (100_000_001, 0), (0, 1000)]), Err(GeofenceError::TooFar));
    assert_eq!(polygon(&[(0, 0), (i32::MIN, i32::MAX), (0, 1000)]), Err(GeofenceError::TooFar));
    assert!(Geofence::rectangle(Vector::ZERO, Vector::new(0, 5000)).is_err());
    let circle = |radius_mm| Circle { centre: Vector::ZERO, radius_mm };
    assert_eq!(Geofence::circle(circle(999)), Err(GeofenceError::TooSmall));
    assert_eq!(Geofence::circle(circle(u32::MAX)), Err(GeofenceError::TooFar));
    // 5 m/s inside 20 m takes 1.25 m/s² for the turn alone.
    let fence = Geofence::circle(circle(20_000)).unwrap();
    let refused = Gate::new(Limits::default(), fence).unwrap_err();
    assert_eq!(refused, LimitsError::CircleTooSmall { radius_mm: 20_000, least_mm: 25_001 });
}

#[test]
fn depth_is_the_distance_from_the_fence() {
    let mut clockwise = L_SHAPE;
    clockwise.reverse();
    for corners in [L_SHAPE, clockwise] {
        let fence = polygon(&corners).unwrap();
        for ((east, north), depth) in [
            ((20_000, 20_000), 20_000),
            // The inner corner is 3-4-5 away.
            ((37_000, 36_000), 5000),
            ((43_000, 44_000), -3000),
            ((60_000, 20_000), 20_000),
            ((60_000, 60_000), -20_000),
            ((-5000, 95_000), -7071),
            ((0, 0), 0),
            ((0, 45_000), 0),
        ] {
            assert_eq!(fence.depth_mm(Vector::new(east, north)), depth, "{east} {north}");
        }
    }
    let both = square(100_000).and_circle(Circle { centre: Vector::new(50_000, 50_000), radius_mm: 60_000 }).unwrap();
    assert_eq!(both.depth_mm(Vector::new(50_000, 50_000)), 50_000);
    assert_eq!(both.depth_mm(Vector::new(1000, 1000)), -9296);
    assert_eq!(both.depth_mm(Vector::new(-1000, 50_000)), -1000);
}

/// Inside a polygon (by winding) and a circle, in floats.
fn is_inside(fence: &Geofence, (x, y): (f64, f64)) -> bool {
    let corners: Vec<(f64, f64)> = fence.corners().iter().map(|c| (f64::from(c.east), f64::from(c.north))).collect();
    let turned: f64 = (0..corners.len())
        .map(|i| {
            let ((ax, ay), (bx, by)) = (corners[i], corners[(i + 1) % corners.len()]);
            let (ax, ay, bx, by) = (ax - x, ay - y, bx - x, by - y);
            (ax * by - ay * bx).atan2(ax * bx + ay * by)
        })
        .sum();
    let in_polygon = corners.is_empty() || turned.abs() > PI;
    let in_circle = fence
        .outer_circle()
        .is_none_or(|c| (x - f64::from(c.centre.east)).hypot(y - f64::from(c.centre.north)) <= f64::from(c.radius_mm));
    in_polygon && in_circle
}

/// How the simulated vehicle and its links behave.
#[derive(Clone, Copy, Debug)]
struct Vehicle {
    /// Greatest acceleration, mm/s².
    acceleration: f64,
    /// Time constant with which it follows a velocity, s.
    lag_s: f64,
    /// From a measurement to its arrival, and from a setpoint to its effect, ms.
    transport_ms: u32,
    /// Wind that carries it along, mm/s.
    wind: (f64, f64),
}

/// What the actor does.
#[derive(Clone, Copy, Debug)]
enum Actor {
    /// Full speed in one direction, radians.
    Straight(f64),
    /// A new direction and acceleration at every decision, from a seed.
    Wild(u64),
    /// Along the nearest wall and at it, by turns.
    Skimming(f64),
}

impl Actor {
    fn wants(self, tick: u32, place: (f64, f64)) -> (Vector, Vector) {
        let polar = |length: f64, angle: f64| Vector::new((length * angle.cos()) as i32, (length * angle.sin()) as i32);
        match self {
            Self::Straight(angle) => (polar(5000.0, angle), polar(2500.0, angle)),
            Self::Wild(seed) => {
                let mut hash = seed ^ u64::from(tick / 3).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                hash = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                hash ^= hash >> 32;
                let part = |shift: u32| ((hash >> shift) & 0xffff) as f64 / 65_536.0;
                (polar(9000.0 * part(0), TAU * part(16)), polar(4000.0 * part(32), TAU * part(48)))
            }
            Self::Skimming(angle) => {
                let turn = if tick % 20 < 10 { 1.2 } else { 0.0 };
                let angle = angle + turn + (place.0 + place.1) / 500_000.0;
                (polar(5000.0, angle), polar(2500.0, angle))
            }
        }
    }
}

/// Flies for 60 s from `start` (mm), standing; returns the least depth of the true position, mm.
fn fly(fence: &Geofence, limits: Limits, start: (f64, f64), vehicle: Vehicle, actor: Actor, losses: u64) -> i32 {
    const DT_MS: u32 = 20;
    const TICK_MS: u32 = 200;
    let mut gate = Gate::new(limits, fence.clone()).unwrap();
    let (mut p, mut v) = (start, (0.0, 0.0));
    let mut measured: Vec<(u32, Measured)> = Vec::new();
    let mut commands: Vec<(u32, Vector, Vector)> = Vec::new();
    let mut inputs = Inputs {
        ekf_ok: true,
        gps_fix: Some(3),
        mode: FlightMode::Guided,
        armed: true,
        airborne: true,
        self_test: true,
        operator: Some(Request::Start),
        ..Inputs::default()
    };
    let (mut least, mut streamed) = (i32::MAX, 0);
    for now in (0..60_000).step_by(DT_MS as usize) {
        if now % TICK_MS == 0 {
            let state = Measured {
                time_ms: now,
                position: Vector::new(p.0 as i32, p.1 as i32),
                velocity: Vector::new(v.0 as i32, v.1 as i32),
                altitude_mm: 30_000,
                climb_mm_s: 0,
            };
            let lost = losses.rotate_right(now / TICK_MS) & 1 == 1;
            if !lost {
                measured.push((now + vehicle.transport_ms, state));
            }
            let heard = measured.iter().rev().find(|(at, _)| *at <= now).map(|(_, state)| *state);
            let (velocity, acceleration) = actor.wants(now / TICK_MS, p);
            inputs = Inputs {
                now_ms: Some(now),
                wall_ms: now,
                state: heard,
                heartbeat_ms: Some(now),
                proposal: Some(Proposal { decided_ms: now, velocity, acceleration, altitude_mm: 30_000 }),
                ..inputs
            };
            let verdict = gate.tick(&inputs);
            inputs.operator = None;
            streamed += u32::from(matches!(verdict, Verdict::Stream(_)));
            if let Some(setpoint) = verdict.setpoint() {
                commands.push((now + vehicle.transport_ms, setpoint.velocity, setpoint.acceleration));
            }
        }
        if let Some((_, velocity, forward)) = commands.iter().rev().find(|(at, ..)| *at <= now) {
            let follow =
                |wanted: i32, is: f64, forward: i32| (f64::from(wanted) - is) / vehicle.lag_s + f64::from(forward);
            let a = (follow(velocity.east, v.0, forward.east), follow(velocity.north, v.1, forward.north));
            let length = a.0.hypot(a.1);
            let scale = if length > vehicle.acceleration { vehicle.acceleration / length } else { 1.0 };
            let dt = f64::from(DT_MS) / 1000.0;
            v = (v.0 + a.0 * scale * dt, v.1 + a.1 * scale * dt);
            p = (p.0 + (v.0 + vehicle.wind.0) * dt, p.1 + (v.1 + vehicle.wind.1) * dt);
        }
        least = least.min(fence.depth_mm(Vector::new(p.0 as i32, p.1 as i32)));
        if least < 0 {
            break;
        }
    }
    assert_eq!(least >= 0, is_inside(fence, p) || least == 0, "{p:?}");
    assert!(least < 0 || streamed > 10, "the vehicle hardly flew: {streamed}");
    least
}

const NOMINAL: Vehicle = Vehicle { acceleration: 2500.0, lag_s: 0.3, transport_ms: 60, wind: (0.0, 0.0) };

fn vehicles() -> impl Strategy<Value = Vehicle> {
    (2000.0..4000.0f64, 0.1..0.35f64, 0..5u32).prop_map(|(acceleration, lag_s, transport)| Vehicle {
        acceleration,
        lag_s,
        transport_ms: transport * 20,
        wind: (0.0, 0.0),
    })
}

fn actors() -> impl Strategy<Value = Actor> {
    prop_oneof![
        (0.0..TAU).prop_map(Actor::Straight),
        any::<u64>().prop_map(Actor::Wild),
        (0.0..TAU).prop_map(Actor::Skimming),
    ]
}

/// Star-shaped polygons, convex or not, and circles.
fn fences() -> impl Strategy<Value = Geofence> {
    let star = (3..=MAX_CORNERS, prop::collection::vec(50_000.0..200_000.0f64, MAX_CORNERS)).prop_filter_map(
        "not a fence",
        |(n, radii)| {
            let corners: Vec<Vector> = (0..n)
                .map(|i| {
                    let angle = TAU * i as f64 / n as f64;
                    Vector::new((radii[i] * angle.cos()) as i32, (radii[i] * angle.sin()) as i32)
                })
                .collect();
            Geofence::polygon(&corners).ok()
        },
    );
    let circle = (26_000..300_000u32)
        .prop_map(|radius_mm| Geofence::circle(Circle { centre: Vector::ZERO, radius_mm }).unwrap());
    let cut = (40_000..200_000i32, 40_000..200_000u32).prop_map(|(half, radius_mm)| {
        let corner = Vector::new(half, half);
        let fence = Geofence::rectangle(Vector::ZERO - corner, corner).unwrap();
        fence.and_circle(Circle { centre: Vector::ZERO, radius_mm }).unwrap()
    });
    prop_oneof![star, circle, cut]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases / 8, ..ProptestConfig::default() })]

    #[test]
    fn no_vehicle_enters_the_margin(fence in fences(), vehicle in vehicles(), actor in actors(), losses: u64) {
        // A quarter of the measurements is lost, some in a row.
        let losses = losses & losses.rotate_left(1);
        let limits = Limits::default();
        let least = fly(&fence, limits, (0.0, 0.0), vehicle, actor, losses);
        // But for a few centimetres of the vehicle's lag and of rounding.
        let margin = limits.fence_margin_mm.cast_signed();
        prop_assert!(least >= margin - 300, "{} mm into the margin", margin - least);
    }

    #[test]
    fn flying_straight_at_the_fence_ends_near_it(angle in 0.0..TAU, transport in 0..5u32) {
        let vehicle = Vehicle { transport_ms: transport * 20, ..NOMINAL };
        let least = fly(&square(200_000), Limits::default(), (1e5, 1e5), vehicle, Actor::Straight(angle), 0);
        prop_assert!((2900..=3500).contains(&least), "{least}");
    }
}

#[test]
fn a_vehicle_that_brakes_no_better_than_stated_stops_in_a_sharp_corner() {
    let vehicle = Vehicle { acceleration: f64::from(Limits::default().braking_mm_s2), lag_s: 0.2, ..NOMINAL };
    for degrees in [31.0_f64, 40.0, 60.0, 90.0, 120.0] {
        let half = degrees.to_radians() / 2.0;
        // A kite with this corner in the origin, its axis to the east.
        let (east, north) = (120_000, (120_000.0 * half.tan()) as i32);
        let fence = polygon(&[(0, 0), (east, -north), (2 * east, 0), (east, north)]).unwrap();
        let least = fly(&fence, Limits::default(), (1.1e5, 0.0), vehicle, Actor::Straight(PI), 0);
        assert!(least >= 2800, "{degrees}°: {least}");
    }
}

#[test]
fn wind_at_the_fence_is_led_back_against() {
    for wind in [(800.0, 0.0), (-600.0, 500.0), (0.0, -800.0)] {
        let vehicle = Vehicle { wind, ..NOMINAL };
        let least =
            fly(&square(100_000), Limits::default(), (5e4, 5e4), vehicle, Actor::Straight(wind.1.atan2(wind.0)), 0);
        assert!(least >= 0, "{wind:?}: {least}");
    }
}

#[test]
fn a_uav_slides_along_the_fence_at_speed() {
    // At 45° to a wall it keeps what goes along it.
    let mut gate = Gate::new(Limits::default(), square(200_000)).unwrap();
    let state = Measured {
        position: Vector::new(100_000, 3000),
        velocity: Vector::new(3000, 0),
        altitude_mm: 30_000,
        ..Measured::default()
    };
    let inputs = at_once(state, Vector::new(3000, -3000));
    let setpoint = started(&mut gate, inputs).setpoint().unwrap();
    assert_eq!((setpoint.velocity.east, setpoint.limited.fence), (3000, true));
    assert!((0..=2).contains(&setpoint.velocity.north), "{setpoint:?}");
}

#[test]
fn outside_it_comes_back_in_and_returns_home_when_it_cannot() {
    // It stands where it is put.
    let limits = Limits { frozen_ms: None, ..Limits::default() };
    let mut gate = Gate::new(limits, polygon(&L_SHAPE).unwrap()).unwrap();
    let mut state = Measured { position: Vector::new(60_000, 20_000), altitude_mm: 30_000, ..Measured::default() };
    let mut now = 10_000;
    let mut tick = |gate: &mut Gate, state: &mut Measured, start: bool, moves: bool| {
        now += 200;
        state.time_ms = now;
        let inputs = Inputs {
            now_ms: Some(now),
            wall_ms: now,
            heartbeat_ms: Some(now),
            operator: start.then_some(Request::Start),
            ..at_once(*state, Vector::new(0, 5000))
        };
        let inputs = Inputs { proposal: inputs.proposal.map(|p| Proposal { decided_ms: now, ..p }), ..inputs };
        let verdict = gate.tick(&inputs);
        if let (Some(setpoint), true) = (verdict.setpoint(), moves) {
            state.velocity = setpoint.velocity;
            state.position = state.position + setpoint.velocity.scaled(200, 1000);
        }
        verdict
    };
    for n in 0..30 {
        let _ = tick(&mut gate, &mut state, n == 12, true);
    }
    // Set down 2 m beyond the wall; small enough for no jump.
    state.position = Vector::new(70_000, 38_500);
    for _ in 0..12 {
        let _ = tick(&mut gate, &mut state, false, false);
    }
    state.position = Vector::new(70_000, 42_000);
    state.velocity = Vector::ZERO;
    let verdict = tick(&mut gate, &mut state, false, true);
    assert!(matches!(verdict, Verdict::Hold(Reason::OutsideFence, s) if s.velocity.north < 0), "{verdict:?}");
    let mut ticks = 0;
    while !matches!(tick(&mut gate, &mut state, false, true), Verdict::Stream(_)) {
        ticks += 1;
        assert!(ticks < 40, "not back: {state:?}");
    }
    assert!(state.position.north <= 38_600, "{state:?}");

    // Blown out and kept there.
    state.position = Vector::new(70_000, 41_000);
    state.velocity = Vector::ZERO;
    let held =
        (0..100).take_while(|_| !matches!(tick(&mut gate, &mut state, false, false), Verdict::Return(_))).count();
    assert_eq!(held, 50);
}

/// Inputs of a flight at this state with this wish.
fn at_once(state: Measured, velocity: Vector) -> Inputs {
    Inputs {
        state: Some(state),
        ekf_ok: true,
        gps_fix: Some(3),
        mode: FlightMode::Guided,
        armed: true,
        airborne: true,
        self_test: true,
        proposal: Some(Proposal { velocity, altitude_mm: 30_000, ..Proposal::default() }),
        ..Inputs::default()
    }
}

/// Brings a gate into flight in one place; the last verdict.
fn started(gate: &mut Gate, mut inputs: Inputs) -> Verdict {
    inputs.operator = Some(Request::Start);
    let mut verdict = gate.tick(&inputs);
    for now in (0..4000).step_by(200) {
        inputs.operator = None;
        (inputs.now_ms, inputs.wall_ms, inputs.heartbeat_ms) = (Some(now), now, Some(now));
        inputs.state.as_mut().unwrap().time_ms = now;
        inputs.proposal.as_mut().unwrap().decided_ms = now;
        // It is held in place: a little of a drift, so that it does not look frozen.
        inputs.state.as_mut().unwrap().position.east = 100_000 + (now as i32 / 200 % 2) * 100;
        verdict = gate.tick(&inputs);
    }
    verdict
}
