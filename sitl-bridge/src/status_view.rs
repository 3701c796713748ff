//! The status of a flight on standard error: a table that is redrawn in place, or, where there is no
//! terminal, a line now and then.

use crate::autopilot::Stage;
use crate::node::Status;
use crate::node::run::NodeEvent;
use crate::outlet::{self, Outlet};
use firmware_core::geometry::{COVERAGE_RANGE_U, Vec2};
use std::fmt::Write as _;
use std::io::{self, IsTerminal as _, Write};
use std::time::{Duration, Instant};

/// Shortest time between two redraws.
const REDRAW: Duration = Duration::from_millis(200);
/// How long a reader that is behind is waited for at the end of a flight.
const PARTING: Duration = Duration::from_secs(1);
/// Without a terminal a line is printed whenever all UAVs have started so many more steps.
const STEPS_PER_LINE: u32 = 20;
/// Verdicts of the safety gate that need no attention of the operator.
const NORMAL_VERDICTS: [&str; 2] = ["stream", "bring_up"];

/// How the status of a flight is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewMode {
    /// A table that is redrawn in place.
    Live,
    /// A line now and then.
    Lines,
    /// Not at all; lines for the operator are printed all the same.
    #[default]
    Off,
}

impl ViewMode {
    /// The table on a terminal; lines elsewhere, and when much else is printed.
    #[must_use]
    pub fn detect(verbose: bool) -> Self {
        if !verbose && io::stderr().is_terminal() { Self::Live } else { Self::Lines }
    }
}

/// Returns the columns and rows of the terminal, if it has a size.
pub type TerminalSize = fn() -> Option<(u16, u16)>;

/// Shows the status of a flight.
pub struct StatusView {
    mode: ViewMode,
    out: Out,
    size: TerminalSize,
    title: String,
    first_id: u16,
    rows: Vec<Row>,
    pois: Vec<Vec2>,
    /// Number of lines of the table that is on the terminal.
    drawn: usize,
    drawn_at: Option<Instant>,
    /// Without a terminal, as of the last line: steps that all UAVs had started, and whether all flew.
    printed: (u32, bool),
}

/// Where the status goes.
enum Out {
    /// An output that is waited for.
    Plain(Box<dyn Write + Send>),
    /// Standard error, which is not.
    Outlet(&'static Outlet),
}

impl Out {
    /// Writes a text; says whether it was. When standard error is closed the flight goes on all the same.
    fn write(&mut self, text: &str) -> bool {
        match self {
            Self::Plain(out) => out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_ok(),
            Self::Outlet(outlet) => outlet.write(text),
        }
    }

    /// Writes a text that another will replace, unless the reader is behind.
    fn offer(&mut self, text: &str) -> bool {
        match self {
            Self::Plain(_) => self.write(text),
            Self::Outlet(outlet) => outlet.offer(text),
        }
    }
}

#[derive(Clone, Debug, Default)]
struct Row {
    status: Option<Status>,
    /// Number of steps started.
    steps: u32,
    flies: bool,
}

impl StatusView {
    /// The status of `count` UAVs with ids from `first_id` on, which cover these PoIs, on standard error.
    #[must_use]
    pub fn new(mode: ViewMode, title: String, first_id: u16, count: usize, pois: &[Vec2]) -> Self {
        Self::to(Out::Outlet(outlet::stderr()), terminal_size, mode, title, first_id, count, pois)
    }

    /// As [`StatusView::new`], on another output.
    #[must_use]
    pub fn on(
        out: Box<dyn Write + Send>,
        size: TerminalSize,
        mode: ViewMode,
        title: String,
        first_id: u16,
        count: usize,
        pois: &[Vec2],
    ) -> Self {
        Self::to(Out::Plain(out), size, mode, title, first_id, count, pois)
    }

    fn to(
        out: Out,
        size: TerminalSize,
        mode: ViewMode,
        title: String,
        first_id: u16,
        count: usize,
        pois: &[Vec2],
    ) -> Self {
        let rows = vec![Row::default(); count];
        let pois = pois.to_vec();
        Self { mode, out, size, title, first_id, rows, pois, drawn: 0, drawn_at: None, printed: (0, false) }
    }

    /// Takes in an event of the `index`-th UAV.
    pub fn update(&mut self, index: usize, event: &NodeEvent) {
        let Some(row) = self.rows.get_mut(index) else { return };
        match event {
            NodeEvent::Status(status) => row.status = Some((**status).clone()),
            NodeEvent::Stage(stage) => row.flies = *stage == Stage::Flying,
            NodeEvent::StepStarted(step) => row.steps = step.step.saturating_add(1),
            _ => return,
        }
        match self.mode {
            ViewMode::Live if self.drawn_at.is_none_or(|at| at.elapsed() >= REDRAW) => self.draw(),
            ViewMode::Lines => self.print_line(),
            ViewMode::Live | ViewMode::Off => {}
        }
    }

    /// Prints a line for the operator above the table.
    pub fn print(&mut self, line: &str) {
        let text = format!("{}{line}\n", self.erase());
        if self.out.write(&text) {
            self.drawn = 0;
        }
        if self.mode == ViewMode::Live && self.drawn_at.is_some() {
            self.draw();
        }
    }

    /// Draws the table a last time and leaves it on the terminal.
    pub fn finish(&mut self) {
        if self.mode == ViewMode::Live && self.drawn_at.is_some() {
            self.drain();
            self.draw();
            self.drawn = 0;
        }
        self.drain();
    }

    /// What is written elsewhere from here on comes after what was written here, where somebody reads it.
    fn drain(&self) {
        if let Out::Outlet(outlet) = &self.out {
            outlet.drain(PARTING);
        }
    }

    /// Erases the table.
    pub fn clear(&mut self) {
        let erase = self.erase();
        (self.drawn, self.drawn_at) = (0, None);
        if !erase.is_empty() {
            self.out.write(&erase);
        }
        self.drain();
    }

    fn draw(&mut self) {
        let lines = self.table();
        let mut text = self.erase();
        for line in &lines {
            text.push_str(line);
            text.push('\n');
        }
        self.drawn_at = Some(Instant::now());
        if self.out.offer(&text) {
            self.drawn = lines.len();
        }
    }

    /// The control sequence that erases the table: up to its first line, and everything from there.
    fn erase(&self) -> String {
        if self.drawn == 0 { String::new() } else { format!("\r\x1b[{}A\x1b[J", self.drawn) }
    }

    fn table(&self) -> Vec<String> {
        // The size of a terminal that reports none.
        let (columns, rows) = (self.size)().filter(|&(columns, _)| columns > 0).unwrap_or((80, 24));
        // Headline, column heads, a line for the UAVs left out, and the cursor's line.
        let room = usize::from(rows).saturating_sub(4).max(1);
        let mut lines = vec![self.headline(), head()];
        let troubled = |&i: &usize| self.rows[i].status.as_ref().is_none_or(|status| !is_well(status));
        let mut shown: Vec<usize> = (0..self.rows.len()).collect();
        if shown.len() > room {
            // UAVs that need attention are shown before all others.
            shown.sort_by_key(|i| (!troubled(i), *i));
            shown.truncate(room);
            shown.sort_unstable();
        }
        lines.extend(shown.iter().map(|&i| self.line(i)));
        if shown.len() < self.rows.len() {
            lines.push(format!("  and {} more", self.rows.len() - shown.len()));
        }
        // The last column stays free: some terminals wrap there.
        let width = usize::from(columns).saturating_sub(1);
        lines.iter().map(|line| line.chars().take(width).collect()).collect()
    }

    fn headline(&self) -> String {
        let mut line = self.title.clone();
        let flying = self.rows.iter().filter(|row| row.flies).count();
        let _ = write!(line, "{}{flying} of {} flying", if line.is_empty() { "" } else { ": " }, self.rows.len());
        if let Some(steps) = self.rows.iter().map(|row| row.steps).min().filter(|&steps| steps > 0) {
            let _ = write!(line, ", step {}", steps - 1);
        }
        if let Some(coverage) = self.coverage() {
            let _ = write!(line, ", {:.1} % of {} PoIs covered", 100.0 * coverage, self.pois.len());
        }
        line
    }

    fn line(&self, i: usize) -> String {
        let id = usize::from(self.first_id) + i;
        let Some(s) = &self.rows[i].status else { return format!("! {id:3}  nothing heard of it yet") };
        let mark = if is_well(s) { ' ' } else { '!' };
        let (east, north) = s.state.map_or_else(
            || ("-".into(), "-".into()),
            |state| {
                let (x, y) = state.position.to_u();
                (format!("{x:.1} u"), format!("{y:.1} u"))
            },
        );
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".into());
        let gate = s.reason.map_or_else(|| s.gate.to_owned(), |reason| format!("{}: {}", s.gate, reason.name()));
        format!(
            "{mark} {id:3}  {:<8.8}  {:<9.9}  {gate:<22.22}  {:>4}  {:>5}  {:>6}  {:>6}  {east:>7}  {north:>7}  {:>7}  {:>4}",
            s.mode,
            s.stage.name(),
            or_dash(self.rows[i].steps.checked_sub(1).map(|step| step.to_string())),
            format!("{}/{}", s.neighbours.1, s.neighbours.0),
            or_dash(s.link_ms.map(age)),
            or_dash(s.swarm_ms.map(age)),
            or_dash(s.altitude_m.map(|m| format!("{m:.1} m"))),
            or_dash(s.battery.map(|percent| format!("{percent}%"))),
        )
    }

    /// Share of the PoIs in coverage range of any UAV whose position is known.
    fn coverage(&self) -> Option<f64> {
        let places: Vec<Vec2> = self.rows.iter().filter_map(|row| Some(row.status.as_ref()?.state?.position)).collect();
        if places.is_empty() || self.pois.is_empty() {
            return None;
        }
        let near = |poi: &&Vec2| {
            let (x, y) = poi.to_u();
            places.iter().map(|place| place.to_u()).any(|p| (p.0 - x).hypot(p.1 - y) <= COVERAGE_RANGE_U as f32)
        };
        Some(self.pois.iter().filter(near).count() as f64 / self.pois.len() as f64)
    }

    /// Prints a line when one is due.
    fn print_line(&mut self) {
        let all_fly = self.rows.iter().all(|row| row.flies);
        let steps = self.rows.iter().map(|row| row.steps).min().unwrap_or(0);
        let (printed, flew) = self.printed;
        if steps >= printed + STEPS_PER_LINE || (all_fly && !flew) {
            self.printed = (steps - steps % STEPS_PER_LINE, flew || all_fly);
            let mut line = self.headline();
            for (i, row) in self.rows.iter().enumerate() {
                if let Some(status) = row.status.as_ref().filter(|status| flew && !is_well(status)) {
                    let reason = status.reason.map_or_else(String::new, |reason| format!(" ({})", reason.name()));
                    let _ = write!(line, "; UAV {}: {}{reason}", usize::from(self.first_id) + i, status.gate);
                }
            }
            self.print(&line);
        }
    }
}

/// Whether a UAV needs no attention.
fn is_well(status: &Status) -> bool {
    NORMAL_VERDICTS.contains(&status.gate) && status.link_ms.is_some_and(|ms| ms < 2000)
}

/// The heads of the columns, aligned with [`StatusView::line`].
fn head() -> String {
    format!(
        "  {:>3}  {:<8}  {:<9}  {:<22}  {:>4}  {:>5}  {:>6}  {:>6}  {:>7}  {:>7}  {:>7}  {:>4}",
        "UAV", "mode", "stage", "gate", "step", "seen", "link", "swarm", "east", "north", "height", "bat."
    )
}

/// An age in a few characters.
fn age(ms: u64) -> String {
    match ms {
        0..=9_999 => format!("{:.1} s", ms as f64 / 1000.0),
        10_000..=599_999 => format!("{} s", ms / 1000),
        _ => format!("{} min", ms / 60_000),
    }
}

fn terminal_size() -> Option<(u16, u16)> {
    let size = rustix::termios::tcgetwinsize(io::stderr()).ok()?;
    Some((size.ws_col, size.ws_row))
}
