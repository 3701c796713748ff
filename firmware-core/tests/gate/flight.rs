//! From the operator's request to the end of a flight, and who may end it.

use crate::bench::{ALTITUDE_MM, Bench, CRUISE, TICK_MS, is_still};
use firmware_core::gate::{
    FlightMode, Gate, Geofence, Limits, LimitsError, Phase, Proposal, Reason, Request, SwarmLoss, Vector, Verdict,
    altitude_layer_mm,
};

#[test]
fn nothing_is_sent_before_the_operator_asks() {
    let mut bench = Bench::new(Limits::default());
    (bench.inputs.mode, bench.inputs.armed, bench.inputs.airborne) = (FlightMode::Guided, true, true);
    for _ in 0..100 {
        assert_eq!(bench.tick(), Verdict::Silent(Reason::NotStarted));
    }
}

#[test]
fn a_flight_from_request_to_stream() {
    let mut bench = Bench::new(Limits::default());
    bench.inputs.operator = Some(Request::Start);
    bench.inputs.ekf_ok = false;
    // The estimator is still settling.
    assert!(matches!(bench.run(10_000), Verdict::Silent(Reason::EkfUnhealthy)));
    bench.inputs.ekf_ok = true;
    assert_eq!(bench.run(2400), Verdict::BringUp(None));
    (bench.inputs.mode, bench.inputs.armed) = (FlightMode::Guided, true);
    assert_eq!(bench.run(5000), Verdict::BringUp(None));
    assert_eq!(bench.gate.phase(), Phase::BringUp);
    bench.climb();
    bench.inputs.airborne = true;
    let Verdict::Stream(first) = bench.tick() else { panic!("no stream") };
    // It begins at rest.
    assert!(first.velocity.length() <= 500 + 2, "{first:?}");
    assert!(first.limited.acceleration);
    let Verdict::Stream(later) = bench.run(2000) else { panic!("no stream") };
    assert_eq!((later.velocity, later.limited.any()), (CRUISE, false));
    assert_eq!(bench.gate.phase(), Phase::Flight);
}

#[test]
fn a_vehicle_that_hovers_in_guided_is_taken_over_in_the_air() {
    let mut bench = Bench::new(Limits::default());
    (bench.inputs.mode, bench.inputs.armed, bench.inputs.airborne) = (FlightMode::Guided, true, true);
    bench.inputs.state.as_mut().unwrap().altitude_mm = ALTITUDE_MM;
    let _ = bench.run(3000);
    bench.inputs.operator = Some(Request::Start);
    assert!(matches!(bench.tick(), Verdict::Stream(_)));
}

#[test]
fn bring_up_expires() {
    let mut bench = Bench::new(Limits { bring_up_ms: 20_000, ..Limits::default() });
    bench.inputs.operator = Some(Request::Start);
    assert_eq!(bench.run(20_000), Verdict::BringUp(None));
    let within = Reason::BringUpExpired.deadline_ms(bench.gate.limits());
    assert_eq!(bench.run(within - 20_000), Verdict::Silent(Reason::BringUpExpired));
    (bench.inputs.mode, bench.inputs.armed, bench.inputs.airborne) = (FlightMode::Guided, true, true);
    assert_eq!(bench.run(1000), Verdict::Silent(Reason::BringUpExpired));
}

#[test]
fn waiting_for_the_first_word_of_the_vehicle_takes_no_time() {
    let mut bench = Bench::new(Limits { bring_up_ms: 20_000, ..Limits::default() });
    bench.linked = false;
    bench.inputs.operator = Some(Request::Start);
    assert_eq!(bench.run(100_000), Verdict::Silent(Reason::LinkLost));
    bench.linked = true;
    let _ = bench.run(2400);
    assert_eq!(bench.tick(), Verdict::BringUp(None));
}

#[test]
fn the_pilot_keeps_the_vehicle() {
    for in_flight in [false, true] {
        let mut bench =
            if in_flight { Bench::in_flight(Limits::default()) } else { Bench::in_takeoff(Limits::default()) };
        bench.inputs.mode = FlightMode::Other;
        assert_eq!(bench.tick(), Verdict::Silent(Reason::ModeLeft));
        // Even when he flips back through GUIDED.
        bench.inputs.mode = FlightMode::Guided;
        assert_eq!(bench.run(60_000), Verdict::Silent(Reason::ModeLeft));
        bench.inputs.operator = Some(Request::Start);
        bench.inputs.airborne = true;
        let _ = bench.run(1000);
        assert_eq!(bench.gate.phase(), Phase::Flight);
    }
}

#[test]
fn after_a_request_the_mode_may_be_anything_until_it_is_guided() {
    let mut bench = Bench::new(Limits::default());
    bench.inputs.operator = Some(Request::Start);
    let _ = bench.run(2400);
    for mode in [FlightMode::Other, FlightMode::Unknown, FlightMode::Other] {
        bench.inputs.mode = mode;
        assert_eq!(bench.run(5000), Verdict::BringUp(None));
    }
    bench.inputs.mode = FlightMode::Guided;
    assert_eq!(bench.tick(), Verdict::BringUp(None));
    bench.inputs.mode = FlightMode::Other;
    assert_eq!(bench.tick(), Verdict::Silent(Reason::ModeLeft));
}

#[test]
fn a_vehicle_that_disarms_in_takeoff_is_not_armed_again() {
    let mut bench = Bench::in_takeoff(Limits::default());
    bench.inputs.armed = false;
    assert_eq!(bench.tick(), Verdict::Silent(Reason::Disarmed));
    assert_eq!(bench.run(10_000), Verdict::Silent(Reason::Disarmed));
}

#[test]
fn px4_gets_setpoints_before_its_mode_but_none_that_moves() {
    let mut bench = Bench::new(Limits { stream_before_mode: true, ..Limits::default() });
    bench.inputs.operator = Some(Request::Start);
    assert_eq!(bench.run(3000), Verdict::BringUp(None));
    bench.inputs.armed = true;
    bench.climb();
    bench.inputs.airborne = true;
    for _ in 0..20 {
        let Verdict::BringUp(Some(setpoint)) = bench.tick() else { panic!("no setpoint") };
        assert!(is_still(setpoint) && setpoint.altitude_mm == ALTITUDE_MM);
    }
    bench.inputs.mode = FlightMode::Guided;
    assert!(matches!(bench.tick(), Verdict::Stream(_)));
}

#[test]
fn return_is_asked_for_until_the_mode_changes_and_three_times_at_most() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.inputs.battery_permille = Some(200);
    let asked: Vec<u32> =
        (0..200).filter(|_| matches!(bench.tick(), Verdict::Return(Reason::BatteryLow))).map(|n| n * TICK_MS).collect();
    assert_eq!(asked, [3000, 4000, 5000]);

    let mut bench = Bench::in_flight(Limits::default());
    bench.inputs.operator = Some(Request::Return);
    assert_eq!(bench.tick(), Verdict::Return(Reason::OperatorReturn));
    bench.inputs.mode = FlightMode::Other;
    assert_eq!(bench.run(10_000), Verdict::Silent(Reason::OperatorReturn));
    bench.inputs.mode = FlightMode::Guided;
    assert_eq!(bench.run(10_000), Verdict::Silent(Reason::OperatorReturn));
}

#[test]
fn a_battery_that_sags_for_a_moment_or_says_nothing_is_no_cause() {
    let mut bench = Bench::in_flight(Limits::default());
    for _ in 0..20 {
        bench.inputs.battery_permille = Some(200);
        assert!(matches!(bench.run(2800), Verdict::Stream(_)));
        bench.inputs.battery_permille = Some(300);
        assert!(matches!(bench.run(200), Verdict::Stream(_)));
    }
    bench.inputs.battery_permille = None;
    assert!(matches!(bench.run(10_000), Verdict::Stream(_)));
}

#[test]
fn alone_it_flies_on_unless_told_to_hold() {
    let mut bench = Bench::in_flight(Limits::default());
    assert!(matches!(bench.run(60_000), Verdict::Stream(_)));
    let mut bench = Bench::in_flight(Limits { swarm_loss: SwarmLoss::FlyOn, ..Limits::default() });
    bench.inputs.swarm_ms = Some(bench.clock_ms);
    assert!(matches!(bench.run(60_000), Verdict::Stream(_)));
}

#[test]
fn a_vehicle_that_hovers_is_not_frozen() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.deciding = false;
    let still = |bench: &mut Bench| {
        bench.inputs.proposal =
            Some(Proposal { decided_ms: bench.clock_ms, altitude_mm: ALTITUDE_MM, ..Proposal::default() });
        bench.tick()
    };
    for _ in 0..200 {
        assert!(matches!(still(&mut bench), Verdict::Stream(_)));
    }
}

#[test]
fn a_vehicle_that_stopped_unseen_is_not_frozen() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.measuring = false;
    assert_eq!(bench.run(5000), Verdict::Silent(Reason::StateStale));
    // The autopilot has stopped it meanwhile: it stands where it was last seen flying, and soon flies on.
    bench.inputs.state.as_mut().unwrap().velocity = Vector::ZERO;
    bench.measuring = true;
    let verdict = bench.run(Limits::default().clear_ms + 2 * TICK_MS);
    assert!(matches!(verdict, Verdict::Stream(_)), "{verdict:?}");
}

#[test]
fn a_short_gap_in_the_link_is_flown_over() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.linked = false;
    for _ in 0..4 {
        assert!(matches!(bench.tick(), Verdict::Stream(_)));
    }
    bench.linked = true;
    assert!(matches!(bench.tick(), Verdict::Stream(_)));
}

#[test]
fn messages_out_of_order_are_no_restart() {
    let mut bench = Bench::in_flight(Limits::default());
    for _ in 0..20 {
        bench.clock_ms -= 600;
        assert!(matches!(bench.tick(), Verdict::Stream(_)));
        bench.clock_ms += 400;
        assert!(matches!(bench.tick(), Verdict::Stream(_)));
    }
    bench.clock_ms -= 800;
    assert_eq!(bench.tick(), Verdict::Silent(Reason::VehicleRestarted));
}

#[test]
fn a_simulator_may_run_at_any_rate_but_not_leap() {
    let mut bench = Bench::in_flight(Limits::simulation());
    for _ in 0..100 {
        assert!(matches!(bench.tick_after(1000, 1), Verdict::Stream(_)));
        assert!(matches!(bench.tick_after(200, 4000), Verdict::Stream(_)));
    }
    assert_eq!(bench.tick_after(10_001, 1), Verdict::Silent(Reason::ClockJumped));
}

#[test]
fn in_real_time_a_clock_that_runs_ahead_is_another_vehicle() {
    let mut bench = Bench::in_flight(Limits::default());
    assert_eq!(bench.tick_after(2400, 200), Verdict::Silent(Reason::ClockJumped));
    // A request that comes with the leap meant the vehicle before it.
    let mut bench = Bench::in_flight(Limits::default());
    bench.inputs.operator = Some(Request::Start);
    assert_eq!(bench.tick_after(2400, 200), Verdict::Silent(Reason::ClockJumped));
}

#[test]
fn ideal_dynamics_are_not_touched() {
    // Moves 10 m at once every 2 s, at up to 5 m/s, and stands still between.
    let mut bench = Bench::in_flight(Limits::ideal());
    bench.frozen = true;
    bench.deciding = false;
    let mut velocity = Vector::ZERO;
    for step in 0..40 {
        let acceleration = [Vector::new(1768, 1768), Vector::new(-2500, 0), Vector::new(0, -1250)][step % 3];
        for tick in 0..10 {
            let now = bench.clock_ms + TICK_MS;
            let reached = velocity + acceleration.scaled(200 * (tick + 1), 1000);
            let proposed = Proposal {
                decided_ms: now,
                velocity: reached.shortened_to(5000),
                acceleration,
                altitude_mm: ALTITUDE_MM,
            };
            bench.inputs.proposal = Some(proposed);
            bench.inputs.state.as_mut().unwrap().velocity = velocity;
            let Verdict::Stream(setpoint) = bench.tick() else { panic!("step {step}") };
            if step > 0 {
                assert_eq!((setpoint.velocity, setpoint.acceleration), (proposed.velocity, acceleration));
                assert!(!setpoint.limited.any());
            }
        }
        velocity = (velocity + acceleration.scaled(2, 1)).shortened_to(5000);
        let state = bench.inputs.state.as_mut().unwrap();
        state.position = state.position + velocity.scaled(2, 1);
    }
}

#[test]
fn altitude_stays_in_its_band_and_climbs_gently() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.deciding = false;
    for (wanted, target, climb) in [
        (200_000, 120_000, 1500),
        (-5000, 5000, -1500),
        (ALTITUDE_MM + 700, ALTITUDE_MM + 700, 700),
        (i32::MIN, 5000, -1500),
        (i32::MAX, 120_000, 1500),
    ] {
        bench.inputs.proposal =
            Some(Proposal { decided_ms: bench.clock_ms, altitude_mm: wanted, ..Proposal::default() });
        let verdict = bench.tick();
        // Far from its layer it only climbs or descends.
        let far = target.abs_diff(ALTITUDE_MM) > bench.gate.limits().layer_mm;
        assert_eq!(verdict.reason(), far.then_some(Reason::OffLayer), "{wanted}");
        let setpoint = verdict.setpoint().unwrap();
        assert_eq!((setpoint.altitude_mm, setpoint.climb_mm_s), (target, climb));
        assert_eq!(setpoint.limited.altitude, wanted != target);
    }
}

#[test]
fn it_moves_sideways_on_its_layer_only() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.inputs.state.as_mut().unwrap().altitude_mm = ALTITUDE_MM - 8000;
    // Lower by less than what counts as a jump in the seconds since.
    let _ = bench.run(3000);
    let mut heights = Vec::new();
    while let Verdict::Hold(Reason::OffLayer, setpoint) = bench.tick() {
        assert_eq!((setpoint.velocity, setpoint.altitude_mm), (Vector::ZERO, ALTITUDE_MM));
        assert!(setpoint.climb_mm_s > 0);
        let state = bench.inputs.state.as_mut().unwrap();
        state.altitude_mm += setpoint.climb_mm_s / 5;
        heights.push(state.altitude_mm);
    }
    // At half of the distance that counts as off the layer.
    assert!(heights.last().is_some_and(|mm| (28_750..29_050).contains(mm)), "{heights:?}");
    assert!(matches!(bench.tick(), Verdict::Stream(_)));
    bench.inputs.state.as_mut().unwrap().altitude_mm = ALTITUDE_MM + 2400;
    assert!(matches!(bench.tick(), Verdict::Stream(_)));
}

#[test]
fn a_height_that_jumped_is_not_flown_after() {
    let mut bench = Bench::in_flight(Limits::default());
    bench.inputs.state.as_mut().unwrap().altitude_mm += 20_000;
    let mut held = 0;
    while let Verdict::Hold(Reason::PositionJumped, setpoint) = bench.tick() {
        assert_eq!(setpoint.climb_mm_s, 0);
        held += TICK_MS;
    }
    assert!((2000..=2400).contains(&held), "{held}");
    assert_eq!(bench.tick().reason(), Some(Reason::OffLayer));
}

#[test]
fn layers_follow_the_id_and_never_overflow() {
    assert_eq!(altitude_layer_mm(0, 20_000, 2000, 5), 20_000);
    assert_eq!(altitude_layer_mm(7, 20_000, 2000, 5), 24_000);
    assert_eq!(altitude_layer_mm(7, 20_000, 2000, 0), 20_000);
    assert_eq!(altitude_layer_mm(u16::MAX, i32::MAX, u32::MAX, u16::MAX - 1), i32::MAX);
}

#[test]
fn settings_are_checked() {
    let fence = Geofence::rectangle(Vector::ZERO, Vector::new(100_000, 100_000)).unwrap();
    let refused = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        match Gate::new(limits, fence.clone()) {
            Err(LimitsError::OutOfRange { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(|l| l.max_speed_mm_s = 0), "max_speed_mm_s");
    assert_eq!(refused(|l| l.braking_mm_s2 = 2501), "braking_mm_s2");
    assert_eq!(refused(|l| l.altitude_ceiling_mm = 4999), "altitude_ceiling_mm");
    assert_eq!(refused(|l| l.reaction_ms = 100), "reaction_ms");
    assert_eq!(refused(|l| l.release_ms = u32::MAX), "release_ms");
    for limits in [Limits::default(), Limits::simulation(), Limits::ideal()] {
        assert!(Gate::new(limits, fence.clone()).is_ok());
    }
}
