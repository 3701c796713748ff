//! Every cause, one by one: what is done about it, how soon, and how it comes to its end.

use crate::bench::{Bench, TICK_MS, is_still};
use firmware_core::gate::{
    Clock, FailsafeAction, FlightMode, Limits, Phase, Reason, Recovery, Request, SwarmLoss, Vector, Verdict,
};

/// Settings under which a cause can occur, and alone.
fn limits(cause: Reason) -> Limits {
    // Whoever is set down outside the fence has jumped there.
    let jump_mm = Limits::default().jump_mm.filter(|_| cause == Reason::PositionJumped);
    Limits { swarm_loss: SwarmLoss::Hold, jump_mm, ..Limits::default() }
}

fn bench(cause: Reason) -> Bench {
    let mut bench = Bench::in_takeoff(limits(cause));
    bench.inputs.airborne = true;
    bench.inputs.state.as_mut().unwrap().altitude_mm = crate::bench::ALTITUDE_MM;
    for _ in 0..20 {
        hear_swarm(&mut bench);
        let _ = bench.tick();
    }
    assert!(matches!(bench.tick(), Verdict::Stream(_)));
    bench
}

fn hear_swarm(bench: &mut Bench) {
    bench.inputs.swarm_ms = Some(bench.clock_ms.wrapping_add(TICK_MS));
}

/// Makes a cause begin now and go on. False for those that do not arise in flight.
fn begin(bench: &mut Bench, cause: Reason) -> bool {
    let inputs = &mut bench.inputs;
    let state = inputs.state.as_mut().unwrap();
    match cause {
        // Before a flight, or of its beginning: tested in `flight`.
        Reason::NotStarted | Reason::BringUpExpired => return false,
        Reason::OperatorReleased => inputs.operator = Some(Request::Release),
        Reason::OperatorReturn => inputs.operator = Some(Request::Return),
        Reason::SelfTestFailed => inputs.self_test = false,
        Reason::VehicleRestarted => bench.clock_ms = 100,
        Reason::ClockJumped => bench.clock_ms = bench.clock_ms.wrapping_add(3_600_000),
        Reason::ModeLeft => inputs.mode = FlightMode::Other,
        Reason::Disarmed => inputs.armed = false,
        Reason::Landed => inputs.airborne = false,
        Reason::BatteryLow => inputs.battery_permille = Some(250),
        // Blown out, and kept out by the wind.
        Reason::FenceStuck | Reason::OutsideFence => state.position = Vector::new(1_002_000, 0),
        Reason::LinkLost => bench.linked = false,
        Reason::HeartbeatLost => bench.beating = false,
        Reason::StateStale => bench.measuring = false,
        Reason::NumberRefused => inputs.refused = true,
        Reason::EkfUnhealthy => inputs.ekf_ok = false,
        Reason::GpsLost => inputs.gps_fix = Some(2),
        Reason::SourcesDisagree => inputs.sources_disagree = true,
        Reason::StateFrozen => bench.frozen = true,
        Reason::PositionJumped => state.position = state.position + Vector::new(0, 20_000),
        Reason::OutsideAltitude => state.altitude_mm = 124_000,
        Reason::HeightDoubted => inputs.height_doubted = true,
        Reason::OffLayer => state.altitude_mm += 3000,
        Reason::NoDecision => bench.deciding = false,
        Reason::SwarmIncomplete => inputs.swarm_incomplete = true,
        Reason::SwarmLost => {}
    }
    true
}

/// Ends what [`begin`] began, as far as it goes on.
fn end(bench: &mut Bench, cause: Reason) {
    let inputs = &mut bench.inputs;
    let state = inputs.state.as_mut().unwrap();
    match cause {
        Reason::SelfTestFailed => inputs.self_test = true,
        Reason::ModeLeft => inputs.mode = FlightMode::Guided,
        Reason::Disarmed => inputs.armed = true,
        Reason::Landed => inputs.airborne = true,
        Reason::BatteryLow => inputs.battery_permille = Some(900),
        Reason::FenceStuck | Reason::OutsideFence => state.position = Vector::ZERO,
        Reason::LinkLost => bench.linked = true,
        Reason::HeartbeatLost => bench.beating = true,
        Reason::StateStale => bench.measuring = true,
        Reason::NumberRefused => inputs.refused = false,
        Reason::EkfUnhealthy => inputs.ekf_ok = true,
        Reason::GpsLost => inputs.gps_fix = Some(3),
        Reason::SourcesDisagree => inputs.sources_disagree = false,
        Reason::StateFrozen => {
            bench.frozen = false;
            state.position = state.position + Vector::new(60, 0);
        }
        Reason::OutsideAltitude | Reason::OffLayer => state.altitude_mm = crate::bench::ALTITUDE_MM,
        Reason::HeightDoubted => inputs.height_doubted = false,
        Reason::SwarmIncomplete => inputs.swarm_incomplete = false,
        Reason::NoDecision => bench.deciding = true,
        _ => {}
    }
}

/// A tick in which the cause goes on.
fn suffer(bench: &mut Bench, cause: Reason) -> Verdict {
    if cause != Reason::SwarmLost {
        hear_swarm(bench);
    }
    if matches!(cause, Reason::FenceStuck | Reason::OutsideFence) {
        bench.inputs.state.as_mut().unwrap().position = Vector::new(1_002_000, 0);
    }
    // The vehicle's clock stands still when nothing is heard.
    bench.tick()
}

/// A tick without the cause.
fn recover(bench: &mut Bench) -> Verdict {
    hear_swarm(bench);
    bench.tick()
}

fn acted(verdict: &Verdict, action: FailsafeAction) -> bool {
    match (action, verdict) {
        (FailsafeAction::Silent, Verdict::Silent(_)) | (FailsafeAction::Return, Verdict::Return(_)) => true,
        (FailsafeAction::Stop, Verdict::Hold(_, setpoint)) => is_still(*setpoint),
        (FailsafeAction::Hold, Verdict::Hold(..)) => true,
        _ => false,
    }
}

#[test]
fn every_cause_leads_to_its_action_in_time() {
    for cause in Reason::ALL {
        let mut bench = bench(cause);
        let limits = *bench.gate.limits();
        if !begin(&mut bench, cause) {
            continue;
        }
        // Both clocks go on by a tick each time; of a lost link only the own computer's is seen.
        let mut passed = 0;
        let verdict = loop {
            passed += TICK_MS;
            let verdict = suffer(&mut bench, cause);
            if verdict.reason() == Some(cause) {
                break verdict;
            }
            assert!(passed < 20_000, "{cause:?} goes unnoticed: {verdict:?}");
        };
        assert!(passed <= cause.deadline_ms(&limits), "{cause:?} took {passed} ms");
        assert!(acted(&verdict, cause.action()), "{cause:?}: {verdict:?}");
    }
}

#[test]
fn a_stop_becomes_silence() {
    for cause in Reason::ALL.into_iter().filter(|cause| cause.action() == FailsafeAction::Stop) {
        let mut bench = bench(cause);
        begin(&mut bench, cause);
        while suffer(&mut bench, cause).reason() != Some(cause) {}
        let mut passed = 0;
        while acted(&suffer(&mut bench, cause), FailsafeAction::Stop) {
            passed += TICK_MS;
        }
        assert!(passed < bench.gate.limits().stop_ms, "{cause:?}: still setpoints after {passed} ms");
        for _ in 0..300 {
            assert!(suffer(&mut bench, cause).setpoint().is_none(), "{cause:?}");
        }
    }
}

#[test]
fn without_a_time_to_stop_silence_begins_at_once() {
    let mut bench = Bench::in_flight(Limits { stop_ms: 0, ..Limits::default() });
    bench.inputs.ekf_ok = false;
    bench.inputs.refused = true;
    assert_eq!(bench.tick(), Verdict::Silent(Reason::NumberRefused));
}

#[test]
fn causes_end_as_stated() {
    for cause in Reason::ALL {
        let mut bench = bench(cause);
        if !begin(&mut bench, cause) {
            continue;
        }
        while suffer(&mut bench, cause).reason() != Some(cause) {}
        for _ in 0..10 {
            let _ = suffer(&mut bench, cause);
        }
        end(&mut bench, cause);
        let clear_ms = bench.gate.limits().clear_ms;
        let resumed = (1..=300).find(|_| matches!(recover(&mut bench), Verdict::Stream(_))).map(|n| n * TICK_MS);
        match cause.recovery() {
            Recovery::Operator => assert_eq!(resumed, None, "{cause:?}"),
            Recovery::Lasting | Recovery::Settled => {
                let ms = resumed.unwrap_or_else(|| panic!("{cause:?} never clears"));
                assert!(ms <= clear_ms + 2 * TICK_MS, "{cause:?} takes {ms} ms to clear");
            }
            Recovery::AtOnce => assert_eq!(resumed, Some(TICK_MS), "{cause:?}"),
        }
        if cause.recovery() == Recovery::Lasting {
            // Not before it has settled, either: 2 s of good ticks, of which the first counts as the beginning.
            assert!(resumed.unwrap_or(0) > clear_ms, "{cause:?} clears too soon: {resumed:?}");
        }
    }
}

#[test]
fn what_only_the_operator_clears_he_does_clear() {
    for cause in Reason::ALL.into_iter().filter(|cause| cause.recovery() == Recovery::Operator) {
        let mut bench = bench(cause);
        if !begin(&mut bench, cause) {
            continue;
        }
        while suffer(&mut bench, cause).reason() != Some(cause) {}
        end(&mut bench, cause);
        for _ in 0..50 {
            let _ = recover(&mut bench);
        }
        bench.inputs.operator = Some(Request::Start);
        let flies = (0..50).any(|_| matches!(recover(&mut bench), Verdict::Stream(_)));
        assert!(flies, "{cause:?}: {:?}", bench.gate.phase());
    }
}

#[test]
fn a_request_while_the_cause_goes_on_does_not_fly() {
    let lasting = Reason::ALL.into_iter().filter(|cause| !matches!(cause.recovery(), Recovery::Operator));
    for cause in lasting.chain([Reason::SelfTestFailed, Reason::ModeLeft, Reason::Disarmed, Reason::BatteryLow]) {
        if matches!(cause, Reason::PositionJumped) {
            continue;
        }
        let mut bench = bench(cause);
        begin(&mut bench, cause);
        while suffer(&mut bench, cause).reason() != Some(cause) {}
        bench.inputs.operator = Some(Request::Start);
        for _ in 0..100 {
            let verdict = suffer(&mut bench, cause);
            assert!(!matches!(verdict, Verdict::Stream(_)), "{cause:?}: {verdict:?}");
        }
    }
}

#[test]
fn a_stop_that_lasts_ends_by_the_operator_only() {
    for cause in Reason::ALL.into_iter().filter(|cause| cause.recovery() == Recovery::Lasting) {
        let mut bench = bench(cause);
        begin(&mut bench, cause);
        let ticks = (bench.gate.limits().release_ms + 5000) / TICK_MS;
        for _ in 0..ticks {
            let _ = suffer(&mut bench, cause);
        }
        assert!(matches!(bench.gate.phase(), Phase::Idle(_)), "{cause:?}");
        end(&mut bench, cause);
        // A link lost for so long is another vehicle's for all that is known.
        for _ in 0..100 {
            assert!(matches!(recover(&mut bench), Verdict::Silent(_)), "{cause:?}");
        }
    }
}

#[test]
fn in_takeoff_causes_keep_the_gate_silent() {
    for cause in Reason::ALL {
        // Nothing is asked of the actor or of the band of altitudes yet, and nobody stands still by mistake.
        let later = matches!(
            cause,
            Reason::Landed
                | Reason::StateFrozen
                | Reason::OutsideAltitude
                | Reason::HeightDoubted
                | Reason::OffLayer
                | Reason::NoDecision
                | Reason::SwarmIncomplete
                | Reason::SwarmLost
                | Reason::OperatorReturn
                | Reason::FenceStuck
        );
        let mut bench = Bench::in_takeoff(limits(cause));
        if later || !begin(&mut bench, cause) {
            continue;
        }
        let within = cause.deadline_ms(bench.gate.limits());
        let mut passed = 0;
        let verdict = loop {
            passed += TICK_MS;
            let verdict = suffer(&mut bench, cause);
            if verdict.reason() == Some(cause) {
                break verdict;
            }
            assert!(passed < 20_000, "{cause:?} goes unnoticed: {verdict:?}");
        };
        assert!(passed <= within, "{cause:?} took {passed} ms");
        assert_eq!(verdict, Verdict::Silent(cause));
    }
}

#[test]
fn the_first_of_several_causes_is_named() {
    let mut bench = bench(Reason::NumberRefused);
    bench.inputs.refused = true;
    bench.deciding = false;
    bench.inputs.proposal = None;
    assert_eq!(suffer(&mut bench, Reason::NumberRefused).reason(), Some(Reason::NumberRefused));
    bench.inputs.mode = FlightMode::Other;
    assert_eq!(suffer(&mut bench, Reason::NumberRefused), Verdict::Silent(Reason::ModeLeft));
    assert!(Reason::ALL.is_sorted());
}

#[test]
fn only_a_lost_link_is_timed_by_the_own_clock() {
    for cause in Reason::ALL {
        assert_eq!(cause.clock() == Clock::Wall, cause == Reason::LinkLost, "{cause:?}");
    }
}
