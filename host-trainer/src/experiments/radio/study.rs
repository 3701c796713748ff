//! The measurement.

use super::conditions::radios;
use crate::eval::{EvalConfig, EvalRow, Watch, evaluate_with_radio};
use covey_env::Evaluation;
use covey_env::radio::{RadioSettings, RadioWorldError};
use firmware_core::actor::{ActorInput, QuantisedActor};

/// One radio's measurement.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) radio: RadioSettings,
    pub(super) row: EvalRow,
    /// Coverage as a share of that without loss, and its standard error.
    pub(super) kept: (f64, f64),
}

/// The whole study: an actor over every radio.
#[derive(Clone, Debug)]
pub struct RadioStudy {
    /// Name and hash of the actor.
    pub(super) actor: String,
    pub(super) config: EvalConfig,
    /// The lossless radio first.
    pub(super) measured: Vec<Measured>,
}

/// Agent-steps that the study of these worlds flies.
#[must_use]
pub fn study_agent_steps(config: &EvalConfig) -> u64 {
    radios().len() as u64 * config.agent_steps()
}

/// Evaluates the actor over every radio of the study; `steps` hears how far it is, in agent-steps, and `watch` sees each row with its number, from 1,
/// and the number of all.
///
/// # Errors
/// When the scenario cannot be built or has too many UAVs.
pub fn study<O: ActorInput>(
    actor: &QuantisedActor<'_, O>,
    config: &EvalConfig,
    steps: Watch<'_>,
    mut watch: impl FnMut(&EvalRow, usize, usize),
) -> Result<RadioStudy, RadioWorldError> {
    let name = format!("{} int8", actor.aggregation().name());
    let radios = radios();
    let (mut measured, mut lossless) = (Vec::new(), None);
    for radio in &radios {
        let (row, evaluation) = evaluate_with_radio(actor, &name, config, radio, steps)?;
        let kept = ratio(&evaluation, lossless.get_or_insert_with(|| evaluation.clone()));
        measured.push(Measured { radio: radio.clone(), row, kept });
        watch(&measured[measured.len() - 1].row, measured.len(), radios.len());
    }
    let actor = format!("{name}, hash {:016x}", actor.content_hash());
    Ok(RadioStudy { actor, config: config.clone(), measured })
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

impl RadioStudy {
    /// The rows, in the order of measurement.
    #[must_use]
    pub fn rows(&self) -> Vec<EvalRow> {
        self.measured.iter().map(|m| m.row.clone()).collect()
    }

    /// The measurement of one radio.
    pub(super) fn of(&self, radio: &RadioSettings) -> Option<&Measured> {
        self.measured.iter().find(|m| m.radio == *radio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use covey_env::EpisodeMetrics;

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
