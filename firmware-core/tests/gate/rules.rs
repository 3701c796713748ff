//! Random sequences of inputs against plain rules that hold whatever happens.

use firmware_core::gate::{
    Circle, FlightMode, Gate, Geofence, Inputs, Limits, Measured, Proposal, ROUNDING_MM_S, Request, SwarmLoss, Vector,
    Verdict,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// Something that happens, and the time after it.
#[derive(Clone, Copy, Debug)]
enum Event {
    Pass,
    Operator(Request),
    FlightMode(FlightMode),
    Armed(bool),
    Airborne(bool),
    Place(Vector),
    Velocity(Vector),
    Altitude(i32),
    Refused(bool),
    Disagree(bool),
    HeightDoubted(bool),
    SwarmIncomplete(bool),
    Ekf(bool),
    Gps(Option<u8>),
    Battery(Option<u16>),
    SelfTest(bool),
    Wish(Option<(Vector, Vector, i32)>),
    /// Whether state, heartbeat, decisions and the swarm's messages go on.
    Flow(bool, bool, bool, bool),
    /// The vehicle's clock moves by this besides.
    Clock(i32),
}

#[derive(Clone, Copy, Debug)]
struct Step {
    event: Event,
    ticks: u8,
    tick_ms: u16,
    wall_ms: u16,
}

fn vector(reach: i32) -> impl Strategy<Value = Vector> {
    let part = move || prop_oneof![8 => -reach..=reach, 1 => Just(i32::MAX), 1 => Just(i32::MIN)];
    (part(), part()).prop_map(|(east, north)| Vector::new(east, north))
}

/// Mostly about where the vehicle flies.
fn wished_altitude() -> impl Strategy<Value = i32> {
    prop_oneof![3 => 27_000..33_000i32, 1 => any::<i32>()]
}

fn events() -> impl Strategy<Value = Event> {
    prop_oneof![
        6 => Just(Event::Pass),
        4 => Just(Event::Operator(Request::Start)),
        1 => prop_oneof![Just(Request::Release), Just(Request::Return)].prop_map(Event::Operator),
        2 => prop_oneof![3 => Just(FlightMode::Guided), 1 => Just(FlightMode::Other), 1 => Just(FlightMode::Unknown)].prop_map(Event::FlightMode),
        1 => prop::bool::weighted(0.8).prop_map(Event::Armed),
        1 => prop::bool::weighted(0.8).prop_map(Event::Airborne),
        2 => vector(130_000).prop_map(Event::Place),
        2 => vector(9000).prop_map(Event::Velocity),
        1 => prop_oneof![4 => 0..150_000, 1 => any::<i32>()].prop_map(Event::Altitude),
        1 => any::<bool>().prop_map(Event::Refused),
        1 => any::<bool>().prop_map(Event::Disagree),
        1 => any::<bool>().prop_map(Event::Ekf),
        1 => any::<Option<u8>>().prop_map(Event::Gps),
        1 => prop::option::of(0..1000u16).prop_map(Event::Battery),
        1 => prop::bool::weighted(0.8).prop_map(Event::SelfTest),
        6 => prop::option::weighted(0.9, (vector(9000), vector(5000), wished_altitude())).prop_map(Event::Wish),
        1 => any::<bool>().prop_map(Event::HeightDoubted),
        1 => any::<bool>().prop_map(Event::SwarmIncomplete),
        2 => any::<(bool, bool, bool, bool)>().prop_map(|(a, b, c, d)| Event::Flow(a, b, c, d)),
        1 => prop_oneof![-3000..3000i32, any::<i32>()].prop_map(Event::Clock),
        1 => Just(Event::Flow(true, true, true, false)),
        // Health comes back more often than it goes.
        6 => Just(Event::Flow(true, true, true, true)),
        3 => Just(Event::FlightMode(FlightMode::Guided)),
        3 => Just(Event::Armed(true)),
        3 => Just(Event::Airborne(true)),
        3 => Just(Event::SelfTest(true)),
        3 => Just(Event::Ekf(true)),
        3 => Just(Event::Gps(Some(3))),
        3 => Just(Event::Refused(false)),
        3 => Just(Event::Disagree(false)),
        3 => Just(Event::HeightDoubted(false)),
        3 => Just(Event::SwarmIncomplete(false)),
        3 => Just(Event::Battery(Some(800))),
        3 => Just(Event::Altitude(30_000)),
        3 => Just(Event::Place(Vector::ZERO)),
    ]
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = (events(), 1..20u8, prop_oneof![3 => Just(200u16), 1 => 0..1500u16], 0..400u16)
        .prop_map(|(event, ticks, tick_ms, wall_ms)| Step { event, ticks, tick_ms, wall_ms });
    vec(step, 1..120)
}

fn all_limits() -> impl Strategy<Value = Limits> {
    (0..4u8, any::<bool>(), any::<bool>(), 0..3000u32).prop_map(|(kind, px4, hold, stop_ms)| Limits {
        stream_before_mode: px4,
        swarm_loss: if hold { SwarmLoss::Hold } else { SwarmLoss::FlyOn },
        stop_ms,
        ..match kind {
            0 => Limits::default(),
            1 => Limits::ideal(),
            _ => Limits::simulation(),
        }
    })
}

fn gate(limits: Limits) -> Gate {
    let corner = Vector::new(100_000, 100_000);
    Gate::new(limits, Geofence::rectangle(Vector::ZERO - corner, corner).unwrap()).unwrap()
}

/// The inputs of every tick, with clocks that start where they are told.
fn play(steps: &[Step], start_ms: u32, start_wall_ms: u32) -> Vec<Inputs> {
    let (mut now, mut wall) = (start_ms, start_wall_ms);
    let mut wish = Some((Vector::ZERO, Vector::ZERO, 30_000));
    let mut flow = (true, true, true, true);
    let mut inputs = Inputs {
        ekf_ok: true,
        gps_fix: Some(3),
        mode: FlightMode::Guided,
        armed: true,
        airborne: true,
        self_test: true,
        operator: Some(Request::Start),
        state: Some(Measured { time_ms: now, altitude_mm: 30_000, ..Measured::default() }),
        ..Inputs::default()
    };
    let mut played = Vec::new();
    for step in steps {
        let state = inputs.state.as_mut().unwrap();
        match step.event {
            Event::Pass => {}
            Event::Operator(request) => inputs.operator = Some(request),
            Event::FlightMode(mode) => inputs.mode = mode,
            Event::Armed(armed) => inputs.armed = armed,
            Event::Airborne(airborne) => inputs.airborne = airborne,
            Event::Place(place) => state.position = place,
            Event::Velocity(velocity) => state.velocity = velocity,
            Event::Altitude(mm) => state.altitude_mm = mm,
            Event::Refused(refused) => inputs.refused = refused,
            Event::Disagree(disagree) => inputs.sources_disagree = disagree,
            Event::HeightDoubted(doubted) => inputs.height_doubted = doubted,
            Event::SwarmIncomplete(incomplete) => inputs.swarm_incomplete = incomplete,
            Event::Ekf(ok) => inputs.ekf_ok = ok,
            Event::Gps(fix) => inputs.gps_fix = fix,
            Event::Battery(left) => inputs.battery_permille = left,
            Event::SelfTest(passed) => inputs.self_test = passed,
            Event::Wish(new) => wish = new,
            Event::Flow(state, heartbeat, decisions, swarm) => flow = (state, heartbeat, decisions, swarm),
            Event::Clock(ms) => now = now.wrapping_add_signed(ms),
        }
        for _ in 0..step.ticks {
            now = now.wrapping_add(step.tick_ms.into());
            wall = wall.wrapping_add(step.wall_ms.into());
            (inputs.now_ms, inputs.wall_ms) = (Some(now), wall);
            let state = inputs.state.as_mut().unwrap();
            if flow.0 {
                state.time_ms = now;
                state.position = state.position + state.velocity.scaled(step.tick_ms.into(), 1000);
            }
            if flow.1 {
                inputs.heartbeat_ms = Some(now);
            }
            if flow.2 {
                inputs.proposal = wish.map(|(velocity, acceleration, altitude_mm)| Proposal {
                    decided_ms: now,
                    velocity,
                    acceleration,
                    altitude_mm,
                });
            }
            if flow.3 {
                inputs.swarm_ms = Some(now);
            }
            played.push(inputs);
            inputs.operator = None;
        }
    }
    played
}

/// What may happen, told by the inputs alone.
#[derive(Default)]
struct Rules {
    /// The operator's last word was to start, and nothing that ends a flight has happened since.
    ours: bool,
    guided: bool,
    armed: bool,
    /// Commands to return since the operator's last request.
    returns: u8,
    returning: bool,
    clock: Option<u32>,
    /// The own clock when the vehicle's last went on.
    heard_wall: u32,
    last: Option<(u32, Vector)>,
}

impl Rules {
    fn check(&mut self, inputs: &Inputs, verdict: &Verdict, limits: &Limits) -> Result<(), TestCaseError> {
        let now = inputs.now_ms.unwrap();
        let gap = self.clock.map_or(0, |then| now.wrapping_sub(then).cast_signed());
        let late = gap <= 0 && gap.unsigned_abs() <= limits.reorder_ms;
        match inputs.operator {
            Some(Request::Start) => {
                let Self { clock, heard_wall, last, .. } = *self;
                *self = Self { ours: true, clock, heard_wall, last, ..Self::default() };
            }
            Some(Request::Release) => self.ours = false,
            Some(Request::Return) => self.returning = true,
            None => {}
        }
        if !late || self.clock.is_none() {
            let waited = inputs.wall_ms.wrapping_sub(self.heard_wall);
            let slipped = limits.real_time && gap > (limits.clock_slip_ms + waited).cast_signed();
            if self.clock.is_some() && (gap < 0 || slipped || gap.unsigned_abs() > limits.max_gap_ms) {
                // Another vehicle for all that is known, which flew otherwise.
                (self.ours, self.last) = (false, None);
            }
            (self.clock, self.heard_wall) = (Some(now), inputs.wall_ms);
        }
        self.ours &= inputs.self_test;
        self.ours &= !(self.guided && inputs.mode == FlightMode::Other);
        self.ours &= inputs.armed || !self.armed;
        self.guided |= self.ours && inputs.mode == FlightMode::Guided;
        self.armed |= self.ours && inputs.armed;

        // In real time it goes on while nothing is heard.
        let silence = if limits.real_time { inputs.wall_ms.wrapping_sub(self.heard_wall) } else { 0 };
        let now = self.clock.unwrap().wrapping_add(silence);
        if !self.ours {
            prop_assert!(matches!(verdict, Verdict::Silent(_)), "not ours: {verdict:?}");
        }
        match verdict {
            Verdict::Stream(_) => {
                let fresh = |then: u32, limit: u32| now.wrapping_sub(then).cast_signed() <= limit.cast_signed();
                prop_assert!(inputs.mode == FlightMode::Guided && inputs.armed && !self.returning);
                prop_assert!(!inputs.refused && fresh(inputs.state.unwrap().time_ms, limits.stale_ms));
                prop_assert!(fresh(inputs.heartbeat_ms.unwrap(), limits.heartbeat_ms));
                prop_assert!(fresh(inputs.proposal.unwrap().decided_ms, limits.decision_ms));
                prop_assert!(!inputs.height_doubted && !inputs.swarm_incomplete);
                let layer = inputs.proposal.unwrap().altitude_mm;
                let layer = layer.clamp(limits.altitude_floor_mm, limits.altitude_ceiling_mm);
                prop_assert!(inputs.state.unwrap().altitude_mm.abs_diff(layer) <= limits.layer_mm);
            }
            Verdict::Hold(..) => prop_assert!(inputs.mode == FlightMode::Guided && inputs.armed && !self.returning),
            Verdict::BringUp(setpoint) => {
                prop_assert!(!self.returning);
                if let Some(setpoint) = setpoint {
                    prop_assert!(limits.stream_before_mode && inputs.armed && inputs.airborne);
                    prop_assert_eq!((setpoint.velocity, setpoint.climb_mm_s), (Vector::ZERO, 0));
                }
            }
            Verdict::Return(_) => {
                prop_assert!(inputs.mode == FlightMode::Guided);
                (self.returns, self.returning) = (self.returns + 1, true);
                prop_assert!(self.returns <= limits.return_attempts);
            }
            Verdict::Silent(_) => {}
        }
        self.check_setpoint(inputs, verdict, now, limits)
    }

    fn check_setpoint(
        &mut self,
        inputs: &Inputs,
        verdict: &Verdict,
        now: u32,
        limits: &Limits,
    ) -> Result<(), TestCaseError> {
        let Some(setpoint) = verdict.setpoint() else { return Ok(()) };
        prop_assert!(setpoint.velocity.within(limits.max_speed_mm_s), "{setpoint:?}");
        prop_assert!(setpoint.acceleration.within(limits.max_acceleration_mm_s2), "{setpoint:?}");
        prop_assert!(setpoint.climb_mm_s.unsigned_abs() <= limits.climb_mm_s, "{setpoint:?}");
        if matches!(verdict, Verdict::Stream(_)) {
            prop_assert!((limits.altitude_floor_mm..=limits.altitude_ceiling_mm).contains(&setpoint.altitude_mm));
            if let Some((then, velocity)) = self.last
                && !setpoint.limited.fence
                && now.wrapping_sub(then) <= 1000
            {
                let change = (setpoint.velocity - velocity).length();
                let most = limits.max_acceleration_mm_s2 * now.wrapping_sub(then) / 1000 + ROUNDING_MM_S + 1;
                prop_assert!(change <= most, "{change} > {most}: {inputs:?}");
            }
        }
        self.last = Some((now, setpoint.velocity));
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases / 4, ..ProptestConfig::default() })]

    #[test]
    fn the_rules_hold_whatever_happens(steps in steps(), limits in all_limits()) {
        let mut gate = gate(limits);
        let mut rules = Rules::default();
        for inputs in play(&steps, 100_000, 5000) {
            let verdict = gate.tick(&inputs);
            rules.check(&inputs, &verdict, &limits)?;
        }
    }

    #[test]
    fn verdicts_do_not_depend_on_where_the_clocks_start(steps in steps(), limits in all_limits(), now: u32, wall: u32) {
        let (mut here, mut there) = (gate(limits), gate(limits));
        for (a, b) in play(&steps, 100_000, 5000).into_iter().zip(play(&steps, now, wall)) {
            prop_assert_eq!(here.tick(&a), there.tick(&b));
        }
    }
}

/// Settings from end to end of what is allowed, and fences as far away as can be.
fn extremes() -> impl Strategy<Value = (Limits, Geofence)> {
    let end = |ends: [u32; 3]| prop::sample::select(ends.to_vec());
    let rates = (end([100, 5000, 50_000]), end([100, 2500, 50_000]), end([0, 700, 20_000]), end([0, 3000, 1_000_000]));
    let times = (end([10, 200, 1000]), end([1000, 3000, 5000]), end([0, 500, 3_600_000]), end([0, 2000, 3_600_000]));
    let flags = (any::<bool>(), any::<bool>(), any::<bool>());
    let fences = prop::sample::select(vec![
        Geofence::rectangle(Vector::new(-100_000_000, -100_000_000), Vector::new(100_000_000, 100_000_000)),
        Geofence::rectangle(Vector::new(99_900_000, -100_000_000), Vector::new(100_000_000, 100_000_000)),
        Geofence::polygon(&[Vector::new(0, 0), Vector::new(1, 0), Vector::new(0, 1)]),
        Geofence::circle(Circle { centre: Vector::new(-30_000_000, 5), radius_mm: 70_000_000 }),
    ]);
    (rates, times, flags, fences).prop_map(|(rates, times, flags, fence)| {
        let limits = Limits {
            max_speed_mm_s: rates.0,
            max_acceleration_mm_s2: rates.1,
            braking_mm_s2: rates.1.min(2000),
            inward_mm_s: rates.0.min(1000),
            climb_mm_s: rates.2,
            fence_margin_mm: rates.3,
            altitude_floor_mm: if flags.0 { -1_000_000 } else { 10_000_000 },
            altitude_ceiling_mm: 10_000_000,
            altitude_slack_mm: rates.3,
            tick_ms: times.0,
            reaction_ms: times.1,
            stale_ms: times.1,
            confirm_ms: times.2,
            clear_ms: times.2,
            stop_ms: times.3,
            max_gap_ms: times.3.max(500),
            release_ms: times.3,
            decision_ms: times.3,
            real_time: flags.1,
            jump_mm: flags.2.then_some(u32::MAX),
            frozen_ms: flags.2.then_some(times.2),
            ..Limits::default()
        };
        (limits, fence.unwrap())
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases / 4, ..ProptestConfig::default() })]

    #[test]
    fn no_settings_and_no_numbers_are_too_large(steps in steps(), (limits, fence) in extremes()) {
        let mut gate = Gate::new(limits, fence).unwrap();
        for inputs in play(&steps, 0, 0) {
            let Some(setpoint) = gate.tick(&inputs).setpoint() else { continue };
            prop_assert!(setpoint.velocity.within(limits.max_speed_mm_s), "{setpoint:?}");
            prop_assert!(setpoint.acceleration.within(limits.max_acceleration_mm_s2), "{setpoint:?}");
            prop_assert!(setpoint.climb_mm_s.unsigned_abs() <= limits.climb_mm_s, "{setpoint:?}");
        }
    }
}

#[test]
fn the_random_sequences_do_reach_every_verdict() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let mut seen = std::collections::BTreeMap::<String, u32>::new();
    for _ in 0..400 {
        let steps = steps().new_tree(&mut runner).unwrap().current();
        let limits = all_limits().new_tree(&mut runner).unwrap().current();
        let mut gate = gate(limits);
        for inputs in play(&steps, 0, 0) {
            let verdict = gate.tick(&inputs);
            let reason = verdict.reason().map_or("", |reason| reason.name());
            *seen.entry(format!("{} {reason}", verdict.name())).or_default() += 1;
        }
    }
    let reasons = firmware_core::gate::Reason::ALL.map(|reason| reason.name());
    let missing: Vec<&str> =
        reasons.into_iter().filter(|name| !seen.keys().any(|key| key.ends_with(&format!(" {name}")))).collect();
    assert!(missing.is_empty(), "{missing:?}: {seen:#?}");
    assert!(seen.get("stream ").is_some_and(|n| *n > 2000), "{seen:#?}");
}
