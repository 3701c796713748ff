//! Plain progress lines, which depend on episodes alone.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use covey_report::progress::{Mode, Progress, Status};

#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Lines {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }
}

fn status(episodes: u64) -> Status {
    Status {
        done: episodes,
        elapsed: Duration::from_secs(episodes),
        agent_steps_per_s: 999.6,
        coverage: Some(0.25),
        reward: Some(-12.34),
    }
}

#[test]
fn a_line_comes_with_the_first_update_each_mark_and_the_last_episode() {
    let lines = Lines::default();
    let mut progress = Progress::plain(Box::new(lines.clone()), 50, 8);
    for episodes in 1..=8 {
        progress.update(&status(episodes));
    }
    progress.update(&status(8));
    progress.line("saved");
    progress.finish();
    assert_eq!(
        lines.text(),
        [
            " 12 %  1/8 episodes  coverage 0.250  reward -12.3  1.0 k agent-steps/s  7 s left
",
            " 50 %  4/8 episodes  coverage 0.250  reward -12.3  1.0 k agent-steps/s  4 s left
",
            "100 %  8/8 episodes  coverage 0.250  reward -12.3  1.0 k agent-steps/s
",
            "saved
",
        ]
        .concat()
    );
}

#[test]
fn a_resumed_run_tells_the_time_left_from_its_own_pace() {
    let lines = Lines::default();
    let mut progress = Progress::plain(Box::new(lines.clone()), 1, 10_000).resumed_at(5_000);
    let minutes = |n: u64| Duration::from_secs(60 * n);
    progress.update(&Status { done: 5_000, elapsed: minutes(0), ..Status::default() });
    progress.update(&Status { done: 6_000, elapsed: minutes(30), agent_steps_per_s: 1_234_567.0, ..Status::default() });
    assert_eq!(
        lines.text(),
        " 50 %  5000/10000 episodes  0 agent-steps/s\n \
         60 %  6000/10000 episodes  1.23 M agent-steps/s  2 h 00 min left\n"
    );
}

#[test]
fn a_broken_pipe_stops_nothing() {
    struct Broken;
    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Err(io::ErrorKind::BrokenPipe.into())
        }
    }
    let mut progress = Progress::plain(Box::new(Broken), 1, 2);
    progress.update(&status(1));
    progress.line("still here");
    progress.finish();
}

#[test]
fn no_episodes_and_quiet_are_no_trouble() {
    assert_eq!(Mode::detect(true), Mode::Quiet);
    let mut progress = Progress::new(Mode::Quiet, 0);
    progress.update(&status(0));
    let lines = Lines::default();
    Progress::plain(Box::new(lines.clone()), 0, 0).update(&Status::default());
    assert_eq!(lines.text(), "100 %  0/0 episodes  0 agent-steps/s\n");
}
