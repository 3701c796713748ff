//! The radios of the study: losses, delays, bursts and what else a radio can do.

use covey_env::radio::RadioSettings;
use firmware_core::neighbour_table::DEFAULT_STEP_MS;

/// Shares of messages lost.
pub(super) const LOSSES: [f64; 6] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5];
/// Delays, steps.
pub(super) const DELAYS: [u32; 3] = [0, 1, 2];
/// Mean numbers of messages lost in a row.
pub(super) const BURSTS: [f64; 2] = [3.0, 10.0];
/// What else a radio can do.
pub(super) const OTHERS: [&str; 10] = [
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
/// Targets: a share of messages lost, and the share of lossless coverage that must then be left.
pub(super) const TARGETS: [(f64, f64); 2] = [(0.1, 0.95), (0.3, 0.85)];

/// A radio with this share of messages lost, singly or in bursts of this mean length, and this delay.
pub(super) fn lossy(loss: f64, burst: Option<f64>, delay_steps: u32) -> RadioSettings {
    let delay_ms = delay_steps * u32::from(DEFAULT_STEP_MS);
    RadioSettings { loss, burst, delay_ms, ..RadioSettings::default() }
}

/// Every radio of the study, each once, the perfect one first.
pub(super) fn radios() -> Vec<RadioSettings> {
    let delayed = DELAYS.iter().flat_map(|&delay| LOSSES.map(|loss| lossy(loss, None, delay)));
    let bursts = BURSTS.iter().flat_map(|&b| LOSSES.iter().skip(1).map(move |&loss| lossy(loss, Some(b), 0)));
    // The texts are checked by a test.
    let others = OTHERS.iter().filter_map(|text| text.parse().ok());
    delayed.chain(bursts).chain(others).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_radio_of_the_study_can_be_and_comes_once() {
        let radios = radios();
        assert_eq!(radios.len(), DELAYS.len() * LOSSES.len() + BURSTS.len() * (LOSSES.len() - 1) + OTHERS.len());
        assert_eq!(radios[0], RadioSettings::default());
        for (i, radio) in radios.iter().enumerate() {
            assert_eq!(radio.validate(), Ok(()), "{radio}");
            assert!(!radios[..i].contains(radio), "{radio} comes twice");
        }
    }
}
