//! How much coverage is left over a link that loses and delays messages.

use crate::measure::{EvalRow, Trial, mode_name};
use crate::over_link::measure;
use crate::settings::distribution_name;
use covey_env::Evaluation;
use covey_env::radio::{RadioSettings, RadioWorldError};
use covey_report::report::{Chart, Reference, ReportError, Series, chart_svg};
use firmware_core::actor::{ActorInput, QuantisedActor};
use firmware_core::neighbour_table::DEFAULT_STEP_MS;
use std::fmt::Write;

/// Shares of messages lost.
const LOSSES: [f64; 6] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5];
/// Delays, steps.
const DELAYS: [u32; 3] = [0, 1, 2];
/// Mean numbers of messages lost in a row.
const BURSTS: [f64; 2] = [3.0, 10.0];
/// What else a link can do.
const OTHERS: [&str; 10] = [
    "loss=0.7",
    "loss=0.9",
    "loss=1",
    "range_u=34",
    "range_u=18",
    "loss=0.3,range_u=18",
    "jitter_ms=2000",
    "reorder=0.5",
    "duplicate=0.5",
    "corrupt=0.1",
];
/// Loss and the share of lossless coverage that must be left.
const BARS: [(f64, f64); 2] = [(0.1, 0.95), (0.3, 0.85)];

/// One link's measurement.
#[derive(Clone, Debug)]
struct Measured {
    link: RadioSettings,
    row: EvalRow,
    /// Coverage as a share of that without loss, and its standard error.
    kept: (f64, f64),
}

/// The whole measurement.
#[derive(Clone, Debug)]
pub struct LinkStudy {
    actor: String,
    trial: Trial,
    /// The lossless link first.
    measured: Vec<Measured>,
}

fn lossy(loss: f64, burst: Option<f64>, delay_steps: u32) -> RadioSettings {
    let delay_ms = delay_steps * u32::from(DEFAULT_STEP_MS);
    RadioSettings { loss, burst, delay_ms, ..RadioSettings::default() }
}

/// Every link of the study, each once, the perfect one first.
fn links() -> Vec<RadioSettings> {
    let delayed = DELAYS.iter().flat_map(|&delay| LOSSES.map(|loss| lossy(loss, None, delay)));
    let bursts = BURSTS.iter().flat_map(|&b| LOSSES.iter().skip(1).map(move |&loss| lossy(loss, Some(b), 0)));
    // The texts are checked by a test.
    let others = OTHERS.iter().filter_map(|text| text.parse().ok());
    delayed.chain(bursts).chain(others).collect()
}

/// Measures the actor over every link of the study; `watch` sees each row with its number
/// and the number of all.
///
/// # Errors
/// When the scenario cannot be built or has too many UAVs.
pub fn study<O: ActorInput>(
    actor: &QuantisedActor<'_, O>,
    trial: &Trial,
    mut watch: impl FnMut(&EvalRow, usize, usize),
) -> Result<LinkStudy, RadioWorldError> {
    let name = format!("{} int8", actor.aggregation().name());
    let links = links();
    let (mut measured, mut lossless) = (Vec::new(), None);
    for link in &links {
        let (row, evaluation) = measure(actor, &name, trial, link)?;
        let kept = ratio(&evaluation, lossless.get_or_insert_with(|| evaluation.clone()));
        measured.push(Measured { link: link.clone(), row, kept });
        watch(&measured[measured.len() - 1].row, measured.len(), links.len());
    }
    let actor = format!("{name}, hash {:016x}", actor.content_hash());
    Ok(LinkStudy { actor, trial: trial.clone(), measured })
}

/// Mean coverage as a share of another's in the same worlds, and the standard error of it (as
/// both fly the same worlds, what a world allows cancels out).
fn ratio(one: &Evaluation, other: &Evaluation) -> (f64, f64) {
    let n = one.worlds.len() as f64;
    let other_mean = other.mean().coverage;
    let share = one.mean().coverage / other_mean;
    let pairs = one.worlds.iter().zip(&other.worlds);
    let squares: f64 = pairs.map(|(a, b)| (a.coverage - share * b.coverage).powi(2)).sum();
    (share, (squares / (n - 1.0) / n).sqrt() / other_mean)
}

impl LinkStudy {
    /// The rows, in the order of measurement.
    #[must_use]
    pub fn rows(&self) -> Vec<EvalRow> {
        self.measured.iter().map(|m| m.row.clone()).collect()
    }

    fn of(&self, link: &RadioSettings) -> Option<&Measured> {
        self.measured.iter().find(|m| m.link == *link)
    }

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
        let bar =
            |(_, share): &(f64, f64)| Reference { name: percent(*share, 0) + " of lossless", y: share * lossless };
        let silent = self.of(&lossy(1.0, None, 0));
        let silent = silent.map(|m| Reference { name: "nobody hears anybody".into(), y: m.row.coverage });
        chart_svg(&Chart {
            title: "Coverage over a link that loses messages".into(),
            x_label: "messages lost, %".into(),
            y_label: "coverage index".into(),
            y_range: None,
            series: DELAYS.iter().map(late).chain(BURSTS.iter().map(burst)).collect(),
            references: BARS.iter().map(bar).chain(silent).collect(),
        })
    }

    fn curve(&self, name: String, link: impl Fn(f64) -> RadioSettings) -> Series {
        let found = LOSSES.iter().filter_map(|&loss| Some((100.0 * loss, &self.of(&link(loss))?.row)));
        let (points, band) =
            found.map(|(x, r)| ((x, r.coverage), (r.coverage - r.coverage_se, r.coverage + r.coverage_se))).unzip();
        Series { name, points, band: Some(band) }
    }

    /// The page, in Markdown; `picture` is the picture's name and `command` what was typed.
    #[must_use]
    pub fn page(&self, picture: &str, command: &str) -> String {
        let Trial { scenario, seed, worlds, mode } = &self.trial;
        let mut out = format!(
            "# Coverage over a link that loses messages\n\n\
             Written by `{command}`; the same on every machine. {}: {} UAVs, {} PoIs ({}),\n\
             worlds 0 to {} of seed {seed}, actions by {}. [What the link does](radio.md). ± is the standard error over worlds; that of a share\n\
             is of the same worlds in pairs.\n\n\
             ![Coverage over the share of messages lost]({picture})\n\n",
            self.actor,
            scenario.uavs,
            scenario.pois,
            distribution_name(scenario.distribution),
            worlds - 1,
            mode_name(*mode),
        );
        self.write_bars(&mut out);
        out += "\n## Loss and delay\n\nEach message is lost by itself. Coverage, and its share of that without loss and delay.\n\n";
        let delays = DELAYS.map(|d| (lateness(d), lossy(0.0, None, d)));
        self.write_grid(&mut out, &delays);
        out += "\n## Losses in bursts\n\nMessages of one direction are lost in a row, this many in the mean; a step has two. No delay.\n\n";
        let bursts = BURSTS.map(|b| (format!("bursts of {b}"), lossy(0.0, Some(b), 0)));
        self.write_grid(&mut out, &bursts);
        out += "\n## Every row\n\n`host-trainer eval --link LINK` measures one. Known, ghosts, features: neighbours that a UAV knows of, that it\n\
                believes in range and are not, and whose feature it has, each as a share of the neighbours in range.\n\n";
        self.write_rows(&mut out);
        out
    }

    fn write_bars(&self, out: &mut String) {
        for (loss, least) in BARS {
            let Some(m) = self.of(&lossy(loss, None, 0)) else { continue };
            let verdict = if m.kept.0 >= least { "reached" } else { "not reached" };
            let (lost, least) = (percent(loss, 0), percent(least, 0));
            let _ =
                writeln!(out, "- {lost} lost: {} of lossless coverage; the bar is {least}: {verdict}", share(m.kept));
        }
    }

    /// Losses by columns, each a link but for its loss.
    fn write_grid(&self, out: &mut String, columns: &[(String, RadioSettings)]) {
        let _ = writeln!(out, "| lost |{}", columns.iter().map(|(name, _)| format!(" {name} | |")).collect::<String>());
        let _ = writeln!(out, "|--:|{}", "--:|--:|".repeat(columns.len()));
        for loss in LOSSES {
            let found: Vec<_> =
                columns.iter().map(|(_, link)| self.of(&RadioSettings { loss, ..link.clone() })).collect();
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
        *out += "| link | coverage | of lossless | last step | reward | known | ghosts | features |\n|---|--:|--:|--:|--:|--:|--:|--:|\n";
        for Measured { row, kept, .. } in &self.measured {
            let Some(link) = &row.link else { continue };
            let _ = writeln!(
                out,
                "| `{}` | {:.4} ±{:.4} | {} | {:.4} | {:.0} ±{:.0} | {} | {} | {} |",
                link.link,
                row.coverage,
                row.coverage_se,
                share(*kept),
                row.coverage_last,
                row.reward,
                row.reward_se,
                percent(link.neighbours_known, 1),
                percent(link.neighbours_ghost, 1),
                percent(link.neighbours_with_feature, 1),
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

#[cfg(test)]
mod tests {
    use super::*;
    use covey_env::EpisodeMetrics;

    #[test]
    fn every_link_of_the_study_can_be_and_comes_once() {
        let links = links();
        assert_eq!(links.len(), DELAYS.len() * LOSSES.len() + BURSTS.len() * (LOSSES.len() - 1) + OTHERS.len());
        assert_eq!(links[0], RadioSettings::default());
        for (i, link) in links.iter().enumerate() {
            assert_eq!(link.validate(), Ok(()), "{link}");
            assert!(!links[..i].contains(link), "{link} comes twice");
        }
    }

    #[test]
    fn a_share_of_the_same_worlds_has_the_error_of_the_pairs() {
        let worlds = |coverage: [f64; 4]| Evaluation {
            worlds: coverage.map(|coverage| EpisodeMetrics { coverage, ..EpisodeMetrics::default() }).to_vec(),
        };
        let base = worlds([0.2, 0.4, 0.6, 0.8]);
        let (share, error) = ratio(&worlds([0.1, 0.2, 0.3, 0.4]), &base);
        assert!((share - 0.5).abs() < 1e-12 && error < 1e-12, "{share} ± {error}");
        let (share, error) = ratio(&worlds([0.3, 0.3, 0.7, 0.7]), &base);
        // Differences ±0.1 around 0: s = √(0.04/3), over √4 and over the mean of 0.5.
        assert!((share - 1.0).abs() < 1e-12 && (error - (0.04f64 / 3.0 / 4.0).sqrt() / 0.5).abs() < 1e-12, "{error}");
    }
}
