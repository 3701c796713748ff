//! The committed flight with which the simulated autopilots compare their ideal dynamics, bit for bit.

use covey_env::{Scenario, World};
use firmware_core::action::{ACTIONS, Action};
use firmware_core::random::action_draw;
use std::fmt::Write as _;
use std::path::Path;

const UAVS: usize = 6;
const STEPS: u32 = 60;
const HEAD: &str = "\
# An ideal flight: float32 as its bits, hexadecimal.
# The first line: x and y of each UAV at the start, u. Each other line is a step: the action of each UAV, then
# x, y (u), vx and vy (u/step) of each after it. Written by
#   COVEY_BLESS=1 cargo test -p covey-env --test ideal_flight
";

/// Each UAV prefers one direction, so that the edges and the speed cap come into play.
fn action(uav: usize, step: u32) -> Action {
    let draw = action_draw(10, uav as u16, step);
    let index = if draw.is_multiple_of(4) { draw / 4 % ACTIONS as u32 } else { uav as u32 + 2 };
    Action::new(index as u8).expect("less than ACTIONS")
}

fn flight() -> String {
    let scenario = Scenario { uavs: UAVS, ..Scenario::default() };
    let mut world = World::new(&scenario).expect("a valid scenario");
    world.reset(10, 0);
    let mut text = HEAD.to_owned();
    let write = |text: &mut String, numbers: [&[f32]; 4], columns: usize| {
        for uav in 0..UAVS {
            for column in numbers.iter().take(columns) {
                write!(text, " {:08x}", column[uav].to_bits()).expect("strings take all");
            }
        }
        text.push('\n');
    };
    let state = |world: &World| [world.x(), world.y(), world.vx(), world.vy()].map(<[f32]>::to_vec);
    let columns = |state: &[Vec<f32>; 4], text: &mut String, n| write(text, state.each_ref().map(Vec::as_slice), n);
    columns(&state(&world), &mut text, 2);
    for step in 0..STEPS {
        let actions: Vec<Action> = (0..UAVS).map(|uav| action(uav, step)).collect();
        world.step(&actions);
        let names: Vec<String> = actions.iter().map(|action| action.index().to_string()).collect();
        text.push_str(&names.join(" "));
        columns(&state(&world), &mut text, 4);
    }
    text
}

#[test]
fn the_committed_flight_is_this_one() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/ideal_flight.txt");
    let text = flight();
    if std::env::var_os("COVEY_BLESS").is_some() {
        std::fs::write(&path, &text).expect("the data folder can be written");
    }
    let committed = std::fs::read_to_string(&path).expect("tests/data/ideal_flight.txt");
    assert!(committed == text, "the dynamics moved; if that was meant, write the flight anew as its head says");
}
