//! The actor over a link that is not perfect: the rows of `eval --link`.

use crate::measure::{EvalRow, Trial, mode_name};
use covey_env::Evaluation;
use covey_env::policy_seed;
use covey_env::radio::{RadioFigures, RadioPolicy, RadioSettings, RadioWorldError, evaluate_over_radio};
use firmware_core::actor::{ActorInput, QuantisedActor};
use serde::{Deserialize, Serialize};

/// What a link did, in a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkRow {
    /// The link, as `--link` takes it.
    pub link: String,
    /// Datagrams sent; one that is broadcast counts once a receiver.
    pub datagrams_sent: u64,
    /// Of them, those out of range.
    pub datagrams_out_of_range: u64,
    /// Of them, those lost on the way.
    pub datagrams_lost: u64,
    /// Datagrams that arrived, second copies among them.
    pub datagrams_delivered: u64,
    /// Messages that neighbour tables took.
    pub messages_taken: u64,
    /// Messages that they refused.
    pub messages_refused: u64,
    /// Datagrams that were no message.
    pub messages_malformed: u64,
    /// Share of the neighbours in range that their UAV knew of.
    pub neighbours_known: f64,
    /// Neighbours believed in range that were not, for each that was.
    pub neighbours_ghost: f64,
    /// Neighbours believed in range of whom a feature was at hand, for each that was in range.
    pub neighbours_with_feature: f64,
}

impl LinkRow {
    fn new(link: &RadioSettings, figures: &RadioFigures) -> Self {
        let RadioFigures { counts, taken, refused, malformed, neighbours, known, ghosts, features } = *figures;
        let share = |n: u64| n as f64 / neighbours.max(1) as f64;
        Self {
            link: link.to_string(),
            datagrams_sent: counts.sent,
            datagrams_out_of_range: counts.out_of_range,
            datagrams_lost: counts.lost,
            datagrams_delivered: counts.delivered,
            messages_taken: taken,
            messages_refused: refused,
            messages_malformed: malformed,
            neighbours_known: share(known),
            neighbours_ghost: share(ghosts),
            neighbours_with_feature: share(features),
        }
    }
}

/// Measures the actor over the link; `name` goes into the row. Also returns the figures of
/// each world.
///
/// # Errors
/// When the scenario or the link cannot be.
pub fn measure<O: ActorInput>(
    actor: &QuantisedActor<'_, O>,
    name: &str,
    trial: &Trial,
    link: &RadioSettings,
) -> Result<(EvalRow, Evaluation), RadioWorldError> {
    let policy = RadioPolicy::new(*actor, 0, trial.mode, link, trial.scenario.uavs)?;
    let seeds = |index| policy_seed(trial.seed, index);
    let (evaluation, figures) =
        evaluate_over_radio(&trial.scenario, trial.seed, u64::from(trial.worlds), &policy, seeds)?;
    let mut row = EvalRow::new(name, trial, mode_name(trial.mode), &evaluation);
    row.link = Some(LinkRow::new(link, &figures));
    Ok((row, evaluation))
}

/// What links did, a line each, for people.
#[must_use]
pub fn table(rows: &[LinkRow]) -> String {
    let width = rows.iter().map(|r| r.link.len()).max().unwrap_or(0).max(4);
    let mut out = format!(
        "{:<width$} {:>12} {:>12} {:>12} {:>8} {:>8} {:>9}\n",
        "link", "sent", "lost", "refused", "known", "ghosts", "features"
    );
    for r in rows {
        out += &format!(
            "{:<width$} {:>12} {:>12} {:>12} {:>6.1} % {:>6.1} % {:>7.1} %\n",
            r.link,
            r.datagrams_sent,
            r.datagrams_out_of_range + r.datagrams_lost,
            r.messages_refused + r.messages_malformed,
            100.0 * r.neighbours_known,
            100.0 * r.neighbours_ghost,
            100.0 * r.neighbours_with_feature
        );
    }
    out + "known, ghosts, features: neighbours known of, believed in range and not there, and whose feature was at hand,\n\
           each as a share of the neighbours in range\n"
}
