//! How a flight is shown while it lasts.

use crate::sim::{bridge, python, words};
use firmware_core::geometry::{State, Vec2};
use sitl_bridge::autopilot::{Notice, Stage};
use sitl_bridge::node::run::NodeEvent;
use sitl_bridge::node::{Status, StepStart};
use sitl_bridge::status_view::{StatusView, TerminalSize, ViewMode};
use std::io::{self, Write};
use std::sync::{Arc, Mutex};

/// An output that can be looked at.
#[derive(Clone, Default)]
struct Screen(Arc<Mutex<Vec<u8>>>);

impl Write for Screen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Screen {
    fn written(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }

    /// What a terminal shows after all that was written.
    fn shows(&self) -> Vec<String> {
        let mut lines: Vec<String> = vec![String::new()];
        let text = self.written();
        let mut rest = text.as_str();
        while let Some(character) = rest.chars().next() {
            rest = &rest[character.len_utf8()..];
            match character {
                '\n' => lines.push(String::new()),
                '\r' => {}
                '\u{1b}' => {
                    let end = rest.find(|c: char| c.is_ascii_alphabetic()).expect("a whole sequence");
                    match &rest[end..=end] {
                        "A" => {
                            let up: usize = rest[1..end].parse().expect("a number");
                            lines.truncate(lines.len() - up);
                            lines.last_mut().unwrap().clear();
                        }
                        "J" => {}
                        other => panic!("{other}"),
                    }
                    rest = &rest[end + 1..];
                }
                other => lines.last_mut().unwrap().push(other),
            }
        }
        lines.pop();
        lines
    }
}

fn view(mode: ViewMode, size: TerminalSize, count: usize) -> (StatusView, Screen) {
    let screen = Screen::default();
    let pois = [Vec2::from_u(50.0, 52.0), Vec2::from_u(150.0, 150.0)];
    (StatusView::on(Box::new(screen.clone()), size, mode, "world 3".into(), 7, count, &pois), screen)
}

fn status(id: u16, gate: &'static str) -> NodeEvent {
    NodeEvent::Status(Box::new(Status {
        id,
        stage: Stage::Flying,
        mode: "GUIDED".into(),
        gate,
        reason: None,
        state: Some(State { position: Vec2::from_u(50.0, 50.0), velocity: Vec2::default() }),
        altitude_m: Some(12.0),
        step: Some(4),
        link_ms: Some(120),
        swarm_ms: None,
        neighbours: (5, 2),
        battery: Some(98),
    }))
}

fn begun(step: u32) -> NodeEvent {
    NodeEvent::StepStarted(StepStart { step, state: State::default(), common_ms: 0 })
}

const WIDE: TerminalSize = || Some((120, 40));

#[test]
fn the_table_is_redrawn_in_place_and_words_stand_above_it() {
    let (mut view, screen) = view(ViewMode::Live, WIDE, 2);
    for step in 0..5 {
        view.update(0, &begun(step));
        view.update(1, &begun(step));
        view.update(0, &NodeEvent::Stage(Stage::Flying));
        view.update(0, &status(7, "stream"));
        view.update(1, &status(8, "hold"));
        view.print(&format!("word {step}"));
    }
    view.finish();
    let shown = screen.shows();
    let words: Vec<String> = (0..5).map(|i| format!("word {i}")).collect();
    assert_eq!(shown[..5], words, "{shown:#?}");
    assert_eq!(shown[5], "world 3: 1 of 2 flying, step 4, 50.0 % of 2 PoIs covered");
    assert_eq!(shown.len(), 5 + 2 + 2, "one table alone stays: {shown:#?}");
    assert!(shown[7].starts_with("    7  GUIDED") && shown[7].contains("  stream  "), "{shown:#?}");
    for part in ["50.0 u", "12.0 m", "2/5", "0.1 s", "98%"] {
        assert!(shown[7].contains(part), "{part}: {shown:#?}");
    }
    assert!(shown[8].starts_with("!   8") && shown[8].contains("  hold  "), "{shown:#?}");
}

#[test]
fn a_small_terminal_shows_those_that_need_attention() {
    let (mut view, screen) = view(ViewMode::Live, || Some((40, 10)), 30);
    for i in 0..30u16 {
        view.update(usize::from(i), &status(7 + i, if i == 20 { "hold" } else { "stream" }));
    }
    view.finish();
    let shown = screen.shows();
    assert!(shown.len() < 10 && shown.iter().all(|line| line.chars().count() < 40), "{shown:#?}");
    assert!(shown.iter().any(|line| line.starts_with("!  27")), "{shown:#?}");
    assert_eq!(shown.last().unwrap(), "  and 24 more");
}

#[test]
fn a_table_that_is_taken_away_leaves_nothing() {
    let (mut view, screen) = view(ViewMode::Live, WIDE, 3);
    view.update(0, &status(7, "stream"));
    view.clear();
    view.print("done");
    assert_eq!(screen.shows(), ["done"]);
}

#[test]
fn without_a_terminal_there_are_plain_lines_by_steps_alone() {
    let (mut view, screen) = view(ViewMode::Lines, WIDE, 2);
    view.update(0, &NodeEvent::Notice(Notice::info("not of its making")));
    for uav in 0..2 {
        view.update(uav, &NodeEvent::Stage(Stage::Flying));
        view.update(uav, &status(7 + uav as u16, "stream"));
    }
    for step in 0..45 {
        view.update(0, &begun(step));
        view.update(1, &begun(step));
    }
    view.finish();
    let lines: Vec<_> = screen.written().lines().map(str::to_owned).collect();
    assert_eq!(
        lines,
        [
            "world 3: 2 of 2 flying, 50.0 % of 2 PoIs covered",
            "world 3: 2 of 2 flying, step 19, 50.0 % of 2 PoIs covered",
            "world 3: 2 of 2 flying, step 39, 50.0 % of 2 PoIs covered",
        ]
    );
}

#[test]
fn a_flight_into_a_file_has_no_control_characters() {
    let python = python();
    let args = ["swarm", "--sim", "--count", "3", "--steps", "22", "--python", python.to_str().unwrap()];
    let output = bridge(&args);
    let words = words(&output);
    assert!(output.status.success() && !words.contains('\u{1b}'), "{words}");
    assert!(words.contains("3 of 3 flying, step 19, "), "{words}");
}
