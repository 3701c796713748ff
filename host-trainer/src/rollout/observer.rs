//! What UAVs observe in training, over a perfect radio or a lossy one.
//!
//! With `radio_loss` or `radio_delay` every UAV has a neighbour table and hears real messages
//! over the radio model, so it observes what it would in flight. The graph layer then aggregates
//! over the neighbours whose feature has arrived. One difference to flight is left: a late
//! feature is played as the sender's present one, and a missing one leaves the degree too, since
//! a batch holds the features of one step.

use crate::settings::Settings;
use covey_env::radio::{RadioError, RadioObserver, RadioSettings};
use covey_env::random::{below, stream, unit};
use covey_env::{Neighbourhood, ObservationSliceMut, Observer, World};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, SPEED_CAP_U};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, MAX_AGE_STEPS};
use firmware_core::observation::BuildObservation;

/// Range of the radio in training, u: so far that where nothing is lost or late, observations are
/// those over a perfect radio.
const RADIO_RANGE_U: i32 = COMMUNICATION_RANGE_U + MAX_AGE_STEPS * 2 * SPEED_CAP_U;

/// Builds the observations of one world.
#[derive(Clone, Debug)]
pub enum TrainingObserver {
    /// Every message arrives at once.
    Perfect(Observer),
    /// Messages get lost and come late.
    Lossy(Box<RadioObserver>),
}

impl TrainingObserver {
    /// For a world of `uavs` UAVs.
    ///
    /// # Errors
    /// When there are more UAVs than the radio model serves.
    pub fn new(s: &Settings, uavs: usize) -> Result<Self, RadioError> {
        Ok(if s.lossy() {
            Self::Lossy(Box::new(RadioObserver::new(uavs)?))
        } else {
            Self::Perfect(Observer::new(0, s.tie_period))
        })
    }

    /// Begins an episode: nobody has heard anything yet. Tie-breakers and the radio's draws come
    /// from `policy_seed`.
    ///
    /// # Panics
    /// When `radio_loss` is outside its bounds.
    pub fn begin(&mut self, s: &Settings, policy_seed: u64) {
        match self {
            Self::Perfect(observer) => *observer = Observer::new(policy_seed, s.tie_period),
            Self::Lossy(observer) => {
                observer
                    .begin(policy_seed, s.tie_period, &draw_radio(s, policy_seed))
                    .expect("settings within their bounds");
            }
        }
    }

    /// Writes the observation and the kept neighbours of every UAV in the present state. Call it
    /// once a step, since messages travel in it.
    pub fn observe(&mut self, world: &World, out: ObservationSliceMut<'_>, neighbours: &mut [Neighbourhood]) {
        match out {
            ObservationSliceMut::Compact(out) => self.observe_form(world, out, neighbours),
            ObservationSliceMut::Cells(out) => self.observe_form(world, out, neighbours),
        }
    }

    fn observe_form<O: BuildObservation>(&mut self, world: &World, out: &mut [O], neighbours: &mut [Neighbourhood]) {
        match self {
            Self::Perfect(observer) => observer.observe(world, out, neighbours),
            Self::Lossy(observer) => observer.observe(world, out, neighbours),
        }
    }
}

/// Draws the loss and delay of an episode, each uniform from 0 to its setting.
fn draw_radio(s: &Settings, policy_seed: u64) -> RadioSettings {
    let mut random = stream("training link", policy_seed, 0);
    let loss = s.radio_loss * unit(&mut random);
    let delay_ms = below(&mut random, s.radio_delay + 1) * u32::from(DEFAULT_STEP_MS);
    RadioSettings { loss, delay_ms, range_u: Some(RADIO_RANGE_U as f32), ..RadioSettings::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn episodes_draw_loss_and_delay_up_to_the_settings() {
        let s = Settings { radio_loss: 0.4, radio_delay: 2, ..Settings::default() };
        let radios: Vec<_> = (0..500).map(|seed| draw_radio(&s, seed)).collect();
        assert!(radios.iter().all(|r| r.validate().is_ok() && r.loss <= 0.4));
        let mean = radios.iter().map(|r| r.loss).sum::<f64>() / 500.0;
        assert!((mean - 0.2).abs() < 0.02, "{mean}");
        for delay_ms in [0, 2_000, 4_000] {
            let often = radios.iter().filter(|r| r.delay_ms == delay_ms).count();
            assert!(often.abs_diff(167) < 40, "{delay_ms} ms: {often}");
        }
    }

    #[test]
    fn without_loss_or_delay_the_radio_is_perfect() {
        assert!(matches!(TrainingObserver::new(&Settings::default(), 20), Ok(TrainingObserver::Perfect(_))));
        for s in
            [Settings { radio_loss: 0.1, ..Settings::default() }, Settings { radio_delay: 1, ..Settings::default() }]
        {
            assert!(matches!(TrainingObserver::new(&s, 20), Ok(TrainingObserver::Lossy(_))));
        }
    }
}
