//! The page and its picture.

use super::conditions::{BURSTS, DELAYS, LOSSES, TARGETS, lossy};
use super::study::{Measured, RadioStudy};
use crate::eval::EvalConfig;
use crate::settings::word_of;
use covey_env::radio::RadioSettings;
use covey_report::report::{Chart, Reference, ReportError, Series, chart_svg};
use std::fmt::Write;

impl RadioStudy {
    /// The picture: coverage over loss.
    ///
    /// # Errors
    /// [`ReportError`].
    pub fn picture(&self) -> Result<String, ReportError> {
        let late = |&delay: &u32| self.curve(lateness(delay), |loss| lossy(loss, None, delay));
        let burst = |&burst: &f64| {
            self.curve(format!("bursts of {burst}"), |loss| lossy(loss, Some(burst).filter(|_| loss > 0.0), 0))
        };
        let lossless = self.measured.first().map_or(f64::NAN, |m| m.row.coverage);
        let target =
            |(_, share): &(f64, f64)| Reference { name: percent(*share, 0) + " of lossless", y: share * lossless };
        let silent = self.of(&lossy(1.0, None, 0));
        let silent = silent.map(|m| Reference { name: "nobody hears anybody".into(), y: m.row.coverage });
        chart_svg(&Chart {
            title: "Coverage over a radio that loses messages".into(),
            x_label: "messages lost, %".into(),
            y_label: "coverage index".into(),
            y_range: None,
            series: DELAYS.iter().map(late).chain(BURSTS.iter().map(burst)).collect(),
            references: TARGETS.iter().map(target).chain(silent).collect(),
        })
    }

    fn curve(&self, name: String, radio: impl Fn(f64) -> RadioSettings) -> Series {
        let found = LOSSES.iter().filter_map(|&loss| Some((100.0 * loss, &self.of(&radio(loss))?.row)));
        let (points, band) =
            found.map(|(x, r)| ((x, r.coverage), (r.coverage - r.coverage_se, r.coverage + r.coverage_se))).unzip();
        Series { name, points, band: Some(band) }
    }

    /// The page, in Markdown; `picture` is the picture's name and `command` what was typed.
    #[must_use]
    pub fn page(&self, picture: &str, command: &str) -> String {
        let EvalConfig { scenario, seed, worlds, mode } = &self.config;
        let mut out = format!(
            "# Coverage over a radio that loses messages\n\n\
             Written by `{command}`; the same on every machine. {}: {} UAVs, {} PoIs ({}),\n\
             worlds 0 to {} of seed {seed}, actions by {}. [What the radio does](radio.md). ± is the standard error over worlds; that of a share\n\
             is of the same worlds in pairs.\n\n\
             ![Coverage over the share of messages lost]({picture})\n\n",
            self.actor,
            scenario.uavs,
            scenario.pois,
            word_of(scenario.distribution),
            worlds - 1,
            word_of(*mode),
        );
        self.write_targets(&mut out);
        out += "\n## Loss and delay\n\nEach message is lost by itself. Coverage, and its share of that without loss and delay.\n\n";
        let delays = DELAYS.map(|d| (lateness(d), lossy(0.0, None, d)));
        self.write_grid(&mut out, &delays);
        out += "\n## Losses in bursts\n\nMessages of one direction are lost in a row, this many in the mean; a step has two. No delay.\n\n";
        let bursts = BURSTS.map(|b| (format!("bursts of {b}"), lossy(0.0, Some(b), 0)));
        self.write_grid(&mut out, &bursts);
        out += "\n## Every row\n\n`host-trainer eval --radio RADIO` measures one. Known, ghosts, features: neighbours that a UAV knows of, that it\n\
                believes in range and are not, and whose feature it has, each as a share of the neighbours in range.\n\n";
        self.write_rows(&mut out);
        out
    }

    fn write_targets(&self, out: &mut String) {
        for (loss, least) in TARGETS {
            let Some(m) = self.of(&lossy(loss, None, 0)) else { continue };
            let verdict = if m.kept.0 >= least { "reached" } else { "not reached" };
            let (lost, least) = (percent(loss, 0), percent(least, 0));
            let _ = writeln!(
                out,
                "- {lost} lost: {} of lossless coverage; the target is {least}: {verdict}",
                share(m.kept)
            );
        }
    }

    /// Losses by columns, each a radio but for its loss.
    fn write_grid(&self, out: &mut String, columns: &[(String, RadioSettings)]) {
        let _ = writeln!(out, "| lost |{}", columns.iter().map(|(name, _)| format!(" {name} | |")).collect::<String>());
        let _ = writeln!(out, "|--:|{}", "--:|--:|".repeat(columns.len()));
        for loss in LOSSES {
            let found: Vec<_> =
                columns.iter().map(|(_, radio)| self.of(&RadioSettings { loss, ..radio.clone() })).collect();
            if found.iter().all(Option::is_none) {
                continue;
            }
            let cell = |m: Option<&Measured>| match m {
                Some(m) => format!(" {:.4} ±{:.4} | {} |", m.row.coverage, m.row.coverage_se, share(m.kept)),
                None => " | |".into(),
            };
            let _ = writeln!(out, "| {} |{}", percent(loss, 0), found.into_iter().map(cell).collect::<String>());
        }
    }

    fn write_rows(&self, out: &mut String) {
        *out += "| radio | coverage | of lossless | last step | reward | known | ghosts | features |\n|---|--:|--:|--:|--:|--:|--:|--:|\n";
        for Measured { row, kept, .. } in &self.measured {
            let Some(radio) = &row.radio else { continue };
            let _ = writeln!(
                out,
                "| `{}` | {:.4} ±{:.4} | {} | {:.4} | {:.0} ±{:.0} | {} | {} | {} |",
                radio.radio,
                row.coverage,
                row.coverage_se,
                share(*kept),
                row.coverage_last,
                row.reward,
                row.reward_se,
                percent(radio.neighbours_known, 1),
                percent(radio.neighbours_ghost, 1),
                percent(radio.neighbours_with_feature, 1),
            );
        }
    }
}

fn lateness(delay_steps: u32) -> String {
    match delay_steps {
        0 => "no delay".into(),
        1 => "1 step late".into(),
        n => format!("{n} steps late"),
    }
}

fn percent(share: f64, decimals: usize) -> String {
    format!("{:.decimals$} %", 100.0 * share)
}

/// A share and its standard error; none where it is one by definition.
fn share((share, error): (f64, f64)) -> String {
    if error == 0.0 { percent(share, 0) } else { format!("{:.1} ±{:.1} %", 100.0 * share, 100.0 * error) }
}
