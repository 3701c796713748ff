//! What goes wrong with a vehicle, in takeoff, in transit and while it holds its place: the node does what
//! `docs/safety.md` states, in the time that it states, by the vehicle's clock. In real time and with the settings
//! of real flight.

use crate::flight::{Flight, mission, settings};
use crate::vehicle::{Setpoint, TICK_MS};
use firmware_core::gate::{FailsafeAction, Limits, Reason};
use firmware_core::geometry::Vec2;
use sitl_bridge::autopilot::{Firmware, Stage};
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::gate_limits;

const GUIDED: u32 = 4;
const LOITER: u32 = 5;
const RTL: u32 = 6;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Climbs by the autopilot's own takeoff.
    Takeoff,
    /// Flies a decision at 0.5 m/s or more.
    Transit,
    /// In flight, at rest: the mission's steps have not begun.
    Hold,
}

const PHASES: [Phase; 3] = [Phase::Takeoff, Phase::Transit, Phase::Hold];
const FLIGHT: [Phase; 2] = [Phase::Transit, Phase::Hold];

/// The phase's usual cause of holding is no news.
fn usual(phase: Phase) -> Option<Reason> {
    (phase == Phase::Hold).then_some(Reason::NoDecision)
}

fn limits() -> Limits {
    gate_limits(Limits::default(), &mission())
}

/// A node that has brought its vehicle into this phase.
fn in_phase(phase: Phase) -> Flight {
    in_phase_at(phase, 1_000_000)
}

/// The same, begun at a time of the host.
fn in_phase_at(phase: Phase, wall_ms: u64) -> Flight {
    let mut mission = mission();
    if phase == Phase::Hold {
        mission.epoch_unix_ms += 3_600_000;
    }
    let settings = sitl_bridge::node::Settings { limits: limits(), ..settings(5, &mission, true) };
    let mut flight = Flight::with(settings, Firmware::ArduPilot, Vec2::from_u(100.0, 100.0));
    flight.wall_ms = wall_ms;
    let there = match phase {
        Phase::Takeoff => flight.until(60, |f| (3000.0..8000.0).contains(&f.vehicle.height_mm)),
        Phase::Transit => flight.until(90, |f| f.decisions.len() > 1 && f.vehicle.speed() > 2.0),
        Phase::Hold => flight.until(60, |f| f.node.stage() == Stage::Flying),
    };
    assert!(there, "{phase:?}: {:?}", flight.words());
    if phase == Phase::Hold {
        flight.ticks(15);
    }
    // The first tick with the fault tells of it at once.
    flight.until(2, |f| f.vehicle.is_about_to_tell());
    assert_eq!(flight.node.verdict().reason(), usual(phase), "{phase:?}");
    flight
}

/// What the node sent in a phase since then.
struct Since {
    commands: usize,
    setpoints: usize,
}

impl Since {
    fn now(flight: &Flight) -> Self {
        Self { commands: flight.vehicle.commands.len(), setpoints: flight.vehicle.setpoints.len() }
    }

    /// To ask for message rates again, after a reboot, is no command to the vehicle.
    fn commands(&self, flight: &Flight) -> Vec<u16> {
        let all = flight.vehicle.commands[self.commands..].iter().map(|c| c.0);
        all.filter(|&id| id != mav_cmd::SET_MESSAGE_INTERVAL).collect()
    }

    fn setpoints<'f>(&self, flight: &'f Flight) -> &'f [Setpoint] {
        &flight.vehicle.setpoints[self.setpoints..]
    }
}

fn at_rest(setpoint: &Setpoint) -> bool {
    setpoint.velocity == [0.0; 2]
}

/// Lets the fault begin and time pass until the node acts for `reason`; checks the time and, over the next ten
/// seconds of `tick`, the action.
fn expect(phase: Phase, reason: Reason, begin: impl FnOnce(&mut Flight), tick: impl Fn(&mut Flight)) -> Flight {
    let mut flight = in_phase(phase);
    // In takeoff any cause makes the gate silent.
    let action = if phase == Phase::Takeoff { FailsafeAction::Silent } else { reason.action() };
    let deadline_ms = reason.deadline_ms(&limits());
    let last_ms = flight.vehicle.boot_ms;
    begin(&mut flight);
    let began_ms = flight.wall_ms;
    let mut since = Since::now(&flight);
    while flight.node.verdict().reason() != Some(reason) {
        let passed_ms = flight.wall_ms - began_ms;
        assert!(passed_ms < u64::from(deadline_ms), "{phase:?}: {reason:?} not within {deadline_ms} ms of {last_ms}");
        since = Since::now(&flight);
        tick(&mut flight);
    }
    let acted = flight.node.verdict().name();
    assert_eq!(acted, if action == FailsafeAction::Stop { "hold" } else { action.name() }, "{phase:?}, {reason:?}");
    (0..50).for_each(|_| tick(&mut flight));
    let (commands, setpoints) = (since.commands(&flight), since.setpoints(&flight));
    let context = format!("{phase:?}, {reason:?}: commands {commands:?}, setpoints {setpoints:?}");
    match action {
        FailsafeAction::Silent => assert!(commands.is_empty() && setpoints.is_empty(), "{context}"),
        FailsafeAction::Stop => {
            let ticks = (limits().stop_ms / TICK_MS) as usize;
            assert!(setpoints.iter().all(at_rest) && (1..=ticks + 1).contains(&setpoints.len()), "{context}");
            assert!(commands.is_empty(), "{context}");
        }
        FailsafeAction::Hold => {
            assert!(setpoints.len() > 40 && setpoints[25..].iter().all(at_rest), "{context}");
            assert!(commands.is_empty(), "{context}");
        }
        FailsafeAction::Return => {
            assert_eq!(commands, [mav_cmd::DO_SET_MODE], "{context}");
            assert!(setpoints.is_empty() && flight.vehicle.custom_mode == RTL, "{context}");
        }
    }
    flight
}

fn tick(flight: &mut Flight) {
    flight.tick();
}

/// Lets the fault begin; nothing changes.
fn expect_nothing(phase: Phase, begin: impl FnOnce(&mut Flight)) -> Flight {
    let mut flight = in_phase(phase);
    begin(&mut flight);
    let since = Since::now(&flight);
    for _ in 0..50 {
        flight.tick();
        assert_eq!(flight.node.verdict().reason(), usual(phase), "{phase:?}");
    }
    assert_eq!(since.setpoints(&flight).len(), 50, "{phase:?}");
    flight
}

/// When the cause is over, after less than half a minute, the flight goes on; in takeoff the autopilot has finished
/// its climb meanwhile.
fn expect_flight_after(phase: Phase, mut flight: Flight, end: impl FnOnce(&mut Flight)) {
    end(&mut flight);
    let goes_on = |f: &Flight| f.node.stage() == Stage::Flying && f.node.verdict().reason() == usual(phase);
    let clear_s = limits().clear_ms.div_ceil(1000) + 1;
    let climb_s = if phase == Phase::Takeoff { 5 } else { 0 };
    assert!(flight.until(clear_s + climb_s, goes_on), "{phase:?}: {:?}", flight.words());
    let since = Since::now(&flight);
    flight.ticks(20);
    assert_eq!(since.setpoints(&flight).len(), 20, "{phase:?}");
    assert!((flight.vehicle.height_mm - 12_000.0).abs() <= 1000.0);
}

#[test]
fn gps_lost() {
    for phase in PHASES {
        let flight = expect(phase, Reason::GpsLost, |f| f.vehicle.gps_fix = 1, tick);
        expect_flight_after(phase, flight, |f| f.vehicle.gps_fix = 3);
    }
}

#[test]
fn ekf_bad() {
    for phase in PHASES {
        let flight = expect(phase, Reason::EkfUnhealthy, |f| f.vehicle.healthy = false, tick);
        expect_flight_after(phase, flight, |f| f.vehicle.healthy = true);
    }
}

#[test]
fn vertical_estimate_lost() {
    // Vertical velocity, absolute height.
    for flag in [4, 32] {
        for phase in PHASES {
            let flight = expect(phase, Reason::EkfUnhealthy, |f| f.vehicle.lost_flags = flag, tick);
            expect_flight_after(phase, flight, |f| f.vehicle.lost_flags = 0);
        }
    }
}

#[test]
fn nan_telemetry() {
    for phase in PHASES {
        let flight = expect(phase, Reason::NumberRefused, |f| f.vehicle.broken = true, tick);
        expect_flight_after(phase, flight, |f| f.vehicle.broken = false);
    }
}

fn freeze(flight: &mut Flight) {
    flight.vehicle.frozen = Some((flight.vehicle.place, flight.vehicle.velocity));
}

#[test]
fn pose_frozen() {
    expect(Phase::Transit, Reason::StateFrozen, freeze, tick);
    // Who does not move cannot tell, and does no harm.
    expect_nothing(Phase::Hold, freeze);
    let mut flight = in_phase(Phase::Takeoff);
    freeze(&mut flight);
    assert!(flight.until(60, |f| f.node.verdict().reason() == Some(Reason::StateFrozen)), "{:?}", flight.words());
    // As soon as it should have moved: half a metre is not yet flown.
    let (place, from) = (flight.vehicle.place, flight.vehicle.frozen.unwrap().0);
    assert!((place.east_mm - from.east_mm).hypot(place.north_mm - from.north_mm) < 4000.0);
}

#[test]
fn pose_stale() {
    for phase in PHASES {
        let flight = expect(phase, Reason::StateStale, |f| f.vehicle.without_positions = true, tick);
        expect_flight_after(phase, flight, |f| f.vehicle.without_positions = false);
    }
}

#[test]
fn autopilot_link_cut() {
    for phase in PHASES {
        let mut flight = in_phase(phase);
        let began_ms = flight.wall_ms;
        while flight.node.verdict().reason() != Some(Reason::StateStale) {
            assert!(flight.wall_ms - began_ms < u64::from(Reason::StateStale.deadline_ms(&limits())), "{phase:?}");
            flight.tick_unheard();
        }
        flight.lost.clear();
        // Nobody hears the stop; after it there is only the heartbeat.
        (0..5).for_each(|_| flight.tick_unheard());
        assert!(flight.lost.iter().all(|frame| [0, 84].contains(&frame.message_id())), "{phase:?}");
        flight.lost.clear();
        (0..15).for_each(|_| flight.tick_unheard());
        assert!(flight.lost.iter().all(|frame| frame.message_id() == 0), "{phase:?}");
        // Back within ten seconds it goes on; later only with the operator.
        let since = Since::now(&flight);
        flight.ticks(25);
        assert!(!since.setpoints(&flight).is_empty() || phase == Phase::Takeoff, "{phase:?}");
        (0..60).for_each(|_| flight.tick_unheard());
        let since = Since::now(&flight);
        flight.ticks(50);
        assert!(since.setpoints(&flight).is_empty(), "{phase:?}: {:?}", flight.words());
        assert!(since.commands(&flight).is_empty(), "{phase:?}");
    }
}

#[test]
fn simulated_link_cut() {
    // Where the vehicle's clock may run at any speed only the host's tells that it stands still.
    let mut flight = Flight::new(5, Firmware::ArduPilot, true);
    assert!(flight.until(90, |f| f.decisions.len() > 1), "{:?}", flight.words());
    let began_ms = flight.wall_ms;
    while flight.node.verdict().reason() != Some(Reason::LinkLost) {
        let limits = gate_limits(Limits::simulation(), &mission());
        assert!(flight.wall_ms - began_ms < u64::from(limits.link_wall_ms) + 2000, "{:?}", flight.words());
        flight.idle(50);
    }
}

#[test]
fn clock_jump() {
    for phase in PHASES {
        let leap = |ms: u32| move |f: &mut Flight| f.vehicle.boot_ms = f.vehicle.boot_ms.wrapping_add(ms);
        expect(phase, Reason::ClockJumped, leap(5000), tick);
        expect(phase, Reason::ClockJumped, leap(100_000), tick);
        expect(phase, Reason::VehicleRestarted, leap(20_000u32.wrapping_neg()), tick);
    }
    // Back by less it may be an old message: what is said so is not believed, until the clock is where it was.
    for phase in PHASES {
        let mut flight = in_phase(phase);
        flight.vehicle.boot_ms -= 4000;
        let deadline = Reason::StateStale.deadline_ms(&limits()) / TICK_MS;
        (0..deadline).for_each(|_| tick(&mut flight));
        assert_eq!(flight.node.verdict().reason(), Some(Reason::StateStale), "{phase:?}");
        flight.ticks(40);
        assert_eq!(flight.node.verdict().reason().filter(|_| phase != Phase::Takeoff), usual(phase), "{phase:?}");
    }
    // Less than what a busy computer or a late datagram may make of a sound clock.
    expect_nothing(Phase::Transit, |f| f.vehicle.boot_ms += 1000);
}

#[test]
fn time_of_day_jump() {
    // The autopilot corrects its Unix time: steps are other ones, the flight goes on.
    for by_ms in [7000, -7000, 100_000] {
        let mut flight = expect_nothing(Phase::Transit, |f| f.vehicle.unix_ms += by_ms);
        let decisions = flight.decisions.len();
        flight.ticks(50);
        assert_eq!(flight.decisions.len() - decisions, 5, "{by_ms}");
        assert!(flight.said("corrected its clock"));
    }
}

#[test]
fn autopilot_reboot() {
    // Its clock tells of it, or its first heartbeat, whichever comes first.
    for (reason, phase) in PHASES.into_iter().flat_map(|p| [(Reason::VehicleRestarted, p), (Reason::ModeLeft, p)]) {
        let reboot = |f: &mut Flight| {
            if reason == Reason::VehicleRestarted {
                f.tick();
            }
            f.vehicle.boot_ms = 300;
            f.vehicle.armed = false;
            f.vehicle.custom_mode = 0;
        };
        let flight = expect(phase, reason, reboot, tick);
        assert!(!flight.vehicle.armed && flight.vehicle.custom_mode == 0);
    }
}

#[test]
fn pilot_mode_change() {
    for phase in PHASES {
        let take_over = |f: &mut Flight| {
            f.vehicle.custom_mode = LOITER;
            f.vehicle.velocity = [0.0; 2];
        };
        let mut flight = expect(phase, Reason::ModeLeft, take_over, tick);
        // GUIDED is never taken back, not even when the pilot sets it.
        let since = Since::now(&flight);
        flight.ticks(300);
        flight.vehicle.custom_mode = GUIDED;
        flight.ticks(300);
        assert!(since.commands(&flight).is_empty() && since.setpoints(&flight).is_empty(), "{phase:?}");
        flight.node.start();
        assert!(flight.until(60, |f| !since.setpoints(f).is_empty()), "{phase:?}: {:?}", flight.words());
    }
}

#[test]
fn a_heartbeat_that_tells_of_the_pilot_is_heeded_before_anything_is_asked() {
    let changes: [fn(&mut Flight); 2] = [|f| f.vehicle.custom_mode = LOITER, |f| f.vehicle.armed = false];
    for (phase, change) in PHASES.into_iter().flat_map(|phase| changes.map(|change| (phase, change))) {
        let mut flight = in_phase(phase);
        change(&mut flight);
        let since = Since::now(&flight);
        // It comes alone, when no position is due.
        flight.heartbeat();
        assert_eq!(flight.node.verdict().name(), "silent", "{phase:?}");
        flight.ticks(20);
        assert!(since.commands(&flight).is_empty() && since.setpoints(&flight).is_empty(), "{phase:?}");
    }
}

#[test]
fn disarmed() {
    for phase in PHASES {
        expect(phase, Reason::Disarmed, |f| f.vehicle.armed = false, tick);
    }
}

#[test]
fn battery_low() {
    for phase in FLIGHT {
        expect(phase, Reason::BatteryLow, |f| f.vehicle.battery = 20, tick);
    }
    // In takeoff too, before it is up.
    let mut flight = in_phase(Phase::Takeoff);
    let since = Since::now(&flight);
    flight.vehicle.battery = 20;
    let height_mm = flight.vehicle.height_mm;
    flight.vehicle.ceiling_mm = Some(height_mm + 2000.0);
    assert!(flight.until(20, |f| f.vehicle.custom_mode == RTL), "{:?}", flight.words());
    flight.ticks(50);
    assert!(since.commands(&flight) == [mav_cmd::DO_SET_MODE] && flight.vehicle.height_mm < 11_000.0);
    assert!(since.setpoints(&flight).len() <= 15, "{:?}", since.setpoints(&flight));
}

#[test]
fn position_jumps() {
    for phase in PHASES {
        let mut flight = in_phase(phase);
        flight.vehicle.place.east_mm += 20_000.0;
        flight.tick();
        assert_eq!(flight.node.verdict().reason(), Some(Reason::PositionJumped), "{phase:?}");
        let acted = if phase == Phase::Takeoff { "silent" } else { "hold" };
        assert_eq!(flight.node.verdict().name(), acted, "{phase:?}");
        // It settles: the flight goes on.
        assert!(flight.until(3, |f| f.node.verdict().reason() == usual(phase)), "{phase:?}: {:?}", flight.words());
    }
}

#[test]
fn height_jumps() {
    for (phase, by_mm) in PHASES.into_iter().flat_map(|phase| [(phase, 20_000.0), (phase, -9000.0)]) {
        let mut flight = in_phase(phase);
        flight.vehicle.height_error_mm = by_mm;
        flight.tick();
        assert_eq!(flight.node.verdict().reason(), Some(Reason::PositionJumped), "{phase:?}");
        let acted = if phase == Phase::Takeoff { "silent" } else { "hold" };
        assert_eq!(flight.node.verdict().name(), acted, "{phase:?}");
        if phase == Phase::Takeoff {
            // The autopilot goes on with its climb by the height that it has now.
            continue;
        }
        let since = Since::now(&flight);
        // Until it has settled no height is flown to.
        assert!(flight.until(3, |f| f.node.verdict().reason() != Some(Reason::PositionJumped)), "{:?}", flight.words());
        let held = since.setpoints(&flight).len().saturating_sub(1);
        assert!(since.setpoints(&flight)[..held].iter().all(|s| s.climb == 0.0), "{phase:?}");
        // Then it goes to its layer by what is said now, and flies on there.
        let well = |f: &Flight| f.node.stage() == Stage::Flying && f.node.verdict().reason() == usual(phase);
        assert!(flight.until(60, well) || phase == Phase::Hold, "{phase:?} {by_mm}: {:?}", flight.words());
    }
}

#[test]
fn the_hosts_clock_wraps() {
    // The gate takes it in 32 bits.
    let fly = |wall_ms: u64| {
        let mut flight = in_phase_at(Phase::Transit, wall_ms);
        assert!(flight.wall_ms < wall_ms + 60_000);
        flight.ticks(300);
        assert_eq!(flight.node.verdict().reason(), None);
        (flight.decisions.len(), flight.vehicle.setpoints.len(), flight.words().len())
    };
    assert_eq!(fly((1 << 32) - 60_000), fly(1_000_000));
}
