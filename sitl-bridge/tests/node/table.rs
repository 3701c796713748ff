//! Every order and every takeover in every stage, with both autopilots: one cell of the table in
//! `docs/safety.md` each.

use crate::flight::Flight;
use crate::stages::{Stage, let_go_on, pilots_first_mode};
use sitl_bridge::autopilot::{Firmware, Stage as NodeStage};
use sitl_bridge::messages::mav_cmd;
use sitl_bridge::node::OperatorCommand;

const FIRMWARES: [Firmware; 2] = [Firmware::ArduPilot, Firmware::Px4];

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Event {
    Start,
    /// Also Ctrl-C, SIGTERM and SIGHUP.
    Release,
    /// Also the end of the program with `--land-on-exit`.
    Land,
    Return,
    /// The gate's own, when the battery is low.
    OwnReturn,
    /// The pilot changes the mode, and a heartbeat tells of it at once.
    Heard,
    /// The pilot changes the mode just after a heartbeat.
    Unheard,
    /// The same, to the mode in which the bring-up began.
    Back,
}

const ORDERS: [Event; 5] = [Event::Start, Event::Release, Event::Land, Event::Return, Event::OwnReturn];
const TAKEOVERS: [Event; 3] = [Event::Heard, Event::Unheard, Event::Back];

/// What came of it, in the table's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Brought up from the ground, and flown.
    TakesOff,
    /// Flown, without a takeoff.
    Flies,
    /// Setpoints brake it, and then nothing is sent.
    Brakes,
    /// Nothing is commanded any more, and no setpoint sent.
    Silent,
    Lands,
    Returns,
    /// Nothing is commanded, and the operator is told why.
    Told,
    /// The vehicle stays in the mode that the pilot chose, and nothing is commanded.
    Left,
    /// There is no such case.
    None,
}

impl Outcome {
    const fn word(self) -> &'static str {
        match self {
            Self::TakesOff => "takes off",
            Self::Flies => "flies",
            Self::Brakes => "brakes",
            Self::Silent => "silent",
            Self::Lands => "lands",
            Self::Returns => "returns",
            Self::Told => "told",
            Self::Left => "left",
            Self::None => "–",
        }
    }
}

/// What happens after something, in commands, setpoints and words.
struct Since {
    commands: usize,
    setpoints: usize,
    notices: usize,
}

impl Since {
    fn now(flight: &Flight) -> Self {
        let vehicle = &flight.vehicle;
        Self { commands: vehicle.commands.len(), setpoints: vehicle.setpoints.len(), notices: flight.notices.len() }
    }

    /// Commands besides message rates, without repetitions: MAV_CMD, and the mode of a change of mode.
    fn commands(&self, flight: &Flight) -> Vec<(u16, u32)> {
        let all = flight.vehicle.commands[self.commands..].iter().filter(|c| c.0 != mav_cmd::SET_MESSAGE_INTERVAL);
        let mode = |params: &[f32; 7]| match flight.vehicle.firmware {
            Firmware::ArduPilot => params[1] as u32,
            Firmware::Px4 => ((params[2] as u32) << 24) | ((params[1] as u32) << 16),
        };
        let mut commands: Vec<_> =
            all.map(|(id, p)| (*id, if *id == mav_cmd::DO_SET_MODE { mode(p) } else { 0 })).collect();
        commands.dedup();
        commands
    }
}

const fn modes(firmware: Firmware) -> (u32, u32) {
    match firmware {
        Firmware::ArduPilot => (9, 6),
        Firmware::Px4 => ((6 << 24) | (4 << 16), (5 << 24) | (4 << 16)),
    }
}

/// What came of an order, by what was sent since.
fn outcome_of_order(flight: &Flight, since: &Since, cell: &str) -> Outcome {
    let (land, rtl) = modes(flight.vehicle.firmware);
    let commands = since.commands(flight);
    let setpoints = &flight.vehicle.setpoints[since.setpoints..];
    let has = |command: u16| commands.iter().any(|c| c.0 == command);
    let lasts = setpoints.last().is_some_and(|s| flight.vehicle.boot_ms.wrapping_sub(s.at_ms) < 1000);
    let mode = flight.vehicle.custom_mode;
    for (ordered, outcome) in [(land, Outcome::Lands), (rtl, Outcome::Returns)] {
        if commands.last() == Some(&(mav_cmd::DO_SET_MODE, ordered)) && mode == ordered {
            return outcome;
        }
    }
    if flight.node.stage() == NodeStage::Flying && lasts {
        return if has(mav_cmd::NAV_TAKEOFF) { Outcome::TakesOff } else { Outcome::Flies };
    }
    assert!(commands.is_empty() && !lasts, "{cell}: {commands:?}, {} setpoints: {:?}", setpoints.len(), flight.words());
    if flight.notices[since.notices..].iter().any(|n| n.text.contains("not commanded: ")) {
        return Outcome::Told;
    }
    match setpoints.last() {
        Some(last) => {
            assert_eq!((last.velocity, last.acceleration), ([0.0; 2], [0.0; 2]), "{cell}: let go in motion");
            Outcome::Brakes
        }
        None => Outcome::Silent,
    }
}

/// A cell's name.
fn name(stage: Stage, firmware: Firmware, event: Event) -> String {
    format!("{}, {event:?}, {firmware}", stage.name())
}

fn order(stage: Stage, firmware: Firmware, event: Event) -> Outcome {
    let Some(mut flight) = stage.reach(firmware) else { return Outcome::None };
    let cell = name(stage, firmware, event);
    let mut since = Since::now(&flight);
    match event {
        Event::OwnReturn if matches!(stage, Stage::SilentOnGround | Stage::SilentInAir) => return Outcome::None,
        Event::OwnReturn => {
            // As long as a low battery takes to be believed, in this stage.
            flight.vehicle.battery = 10;
            let height_mm = flight.vehicle.height_mm;
            flight.vehicle.ceiling_mm = flight.vehicle.ceiling_mm.or(Some(height_mm));
            flight.ticks(25);
            if flight.vehicle.custom_mode == modes(firmware).1 {
                return outcome_of_order(&flight, &since, &cell);
            }
            since = Since::now(&flight);
        }
        Event::Start => flight.node.command(OperatorCommand::Start),
        Event::Release => flight.node.command(OperatorCommand::Release),
        Event::Land => flight.node.command(OperatorCommand::Land),
        Event::Return => flight.node.command(OperatorCommand::Return),
        Event::Heard | Event::Unheard | Event::Back => panic!("{event:?} is no order"),
    }
    let_go_on(&mut flight);
    if matches!(event, Event::Release | Event::Land) {
        // The end of the program waits no longer.
        let ended = flight.until(4, |f| !f.node.is_ending());
        assert!(ended, "{cell}: the end takes too long");
    }
    flight.ticks(150);
    if event == Event::Return && stage == Stage::Returning {
        // It is done already.
        let is_left = since.commands(&flight).is_empty() && flight.vehicle.custom_mode == modes(firmware).1;
        assert!(is_left, "{cell}: {:?}", flight.words());
        return Outcome::Returns;
    }
    outcome_of_order(&flight, &since, &cell)
}

fn takeover(stage: Stage, firmware: Firmware, event: Event) -> Outcome {
    let Some(mut flight) = stage.reach(firmware) else { return Outcome::None };
    let cell = name(stage, firmware, event);
    let pilots = match (event, firmware) {
        (Event::Back, _) => pilots_first_mode(firmware),
        // POSHOLD, ALTCTL.
        (_, Firmware::ArduPilot) => 16,
        (_, Firmware::Px4) => 2 << 16,
    };
    if event != Event::Heard && !flight.vehicle.without_heartbeats && !stage.name().starts_with("not heard") {
        // Just after a heartbeat, so that a second passes until the next.
        flight.heartbeat();
        flight.vehicle.restart_second();
    }
    flight.vehicle.custom_mode = pilots;
    if !stage.is_in_air(firmware) {
        // Armed and taken off by hand, to the very height of the layer.
        (flight.vehicle.armed, flight.vehicle.height_mm) = (true, 12_000.0);
    }
    let mut since = Since::now(&flight);
    let_go_on(&mut flight);
    if event == Event::Heard {
        flight.heartbeat();
        since = Since::now(&flight);
    }
    flight.ticks(300);
    let commands = since.commands(&flight);
    let setpoints = flight.vehicle.setpoints.len() - since.setpoints;
    assert_eq!(flight.vehicle.custom_mode, pilots, "{cell}: taken with {commands:?}: {:?}", flight.words());
    let most = if event == Event::Heard { 0 } else { 6 };
    assert!(setpoints <= most, "{cell}: {setpoints} setpoints: {:?}", flight.words());
    assert!(event != Event::Heard || commands.is_empty(), "{cell}: {commands:?}: {:?}", flight.words());
    Outcome::Left
}

/// The table as it is: rows are stages, columns events, a cell ArduPilot's outcome and PX4's.
fn cell(stage: Stage, event: Event) -> [Outcome; 2] {
    FIRMWARES.map(|firmware| {
        if TAKEOVERS.contains(&event) { takeover(stage, firmware, event) } else { order(stage, firmware, event) }
    })
}

/// The table as `docs/safety.md` has it.
const DOCUMENT: &str = include_str!("../../../docs/safety.md");
const HEAD: &str = "| stage | `start` | `release`, Ctrl-C | `land` | `return` | battery low | pilot, told at once | pilot, not told yet | pilot, back to the first mode |\n|---|---|---|---|---|---|---|---|---|";

/// One row of the document, by its first column.
fn documented(stage: Stage) -> &'static str {
    let table = DOCUMENT.split("<!-- orders -->\n").nth(1).expect("the table begins");
    let table = table.split("\n<!-- end -->").next().expect("and ends");
    assert!(table.starts_with(HEAD), "the head is {HEAD}");
    let name = format!("| {} |", stage.name());
    table.lines().find(|line| line.starts_with(&name)).unwrap_or_else(|| panic!("no row {:?}", stage.name()))
}

fn check(stage: Stage) {
    let mut flown = format!("| {}", stage.name());
    for &event in ORDERS.iter().chain(&TAKEOVERS) {
        let cell = cell(stage, event);
        for (firmware, outcome) in FIRMWARES.into_iter().zip(cell) {
            let is_allowed = outcome == Outcome::None || allowed(stage, firmware, event).contains(&outcome);
            assert!(is_allowed, "{}: {outcome:?}", name(stage, firmware, event));
        }
        let [ardupilot, px4] = cell.map(Outcome::word);
        flown += &if ardupilot == px4 { format!(" | {px4}") } else { format!(" | {ardupilot}, {px4}") };
    }
    flown += " |";
    let documented = documented(stage);
    assert_eq!(documented, flown, "{stage:?}: the document, and what was flown");
}

/// What a cell may be, whatever the document says.
const fn allowed(stage: Stage, firmware: Firmware, event: Event) -> &'static [Outcome] {
    let in_air = stage.is_in_air(firmware);
    match event {
        Event::Start if in_air => &[Outcome::Flies],
        Event::Start => &[Outcome::TakesOff, Outcome::Flies],
        Event::Release => &[Outcome::Silent, Outcome::Brakes, Outcome::Returns],
        Event::Land if in_air => &[Outcome::Lands],
        Event::Land => &[Outcome::Lands, Outcome::Told],
        Event::Return if in_air => &[Outcome::Returns],
        Event::Return => &[Outcome::Returns, Outcome::Told],
        Event::OwnReturn => &[Outcome::Returns, Outcome::Silent],
        Event::Heard | Event::Unheard | Event::Back => &[Outcome::Left],
    }
}

macro_rules! rows {
    ($($test:ident $stage:ident,)*) => {
        $(
            #[test]
            fn $test() {
                check(Stage::$stage);
            }
        )*

        #[test]
        fn the_document_has_each_row_once() {
            let table = DOCUMENT.split("<!-- orders -->\n").nth(1).unwrap().split("\n<!-- end -->").next().unwrap();
            let rows: Vec<&str> = table.lines().skip(2).map(|line| line.split(" |").next().unwrap()).collect();
            let stages: Vec<String> = [$(Stage::$stage),*].iter().map(|s| format!("| {}", s.name())).collect();
            assert_eq!(rows, stages);
        }
    };
}

rows! {
    not_heard_on_the_ground SilentOnGround,
    not_heard_in_the_air SilentInAir,
    asking_for_rates_on_the_ground SubscribingOnGround,
    asking_for_rates_in_flight SubscribingInAir,
    waiting_for_the_estimator Idle,
    guided_asked_for ModeAsked,
    guided_accepted ModeAccepted,
    arming_asked_for ArmingAsked,
    arming_accepted ArmingAccepted,
    takeoff_asked_for TakeoffAsked,
    takeoff_accepted TakeoffAccepted,
    climbing Climb,
    climbed Climbed,
    in_flight Flight,
    bring_up_failed Failed,
    released Released,
    clock_leapt_ahead ClockAhead,
    clock_leapt_back ClockBack,
    return_asked_for ReturnAsked,
    returning Returning,
}
