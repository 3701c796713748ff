//! What UAVs see in training: each other at once, or what a link brings them.
//!
//! With `radio_loss` or `radio_delay` every UAV has a neighbour table and hears real messages
//! over the link model, so it observes what it would in flight. The graph layer then links the
//! neighbours whose feature is at hand. One difference to flight is left: a late feature is
//! played as the sender's present one, and a missing one leaves the degree too, since a batch
//! holds the features of one step.

use crate::settings::Settings;
use covey_env::radio::{RadioError, RadioObserver, RadioSettings};
use covey_env::random::{below, stream, unit};
use covey_env::{Neighbourhood, ObservationSliceMut, Observer, World};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, SPEED_CAP_U};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, MAX_AGE_STEPS};
use firmware_core::observation::BuildObservation;

/// How far training's radio reaches, u: where nothing is lost it is a perfect one.
const REACH_U: i32 = COMMUNICATION_RANGE_U + MAX_AGE_STEPS * 2 * SPEED_CAP_U;

/// The observations of one world.
#[derive(Clone, Debug)]
pub enum Eyes {
    /// Every message arrives at once.
    Perfect(Observer),
    /// Messages go over a link.
    Linked(Box<RadioObserver>),
}

impl Eyes {
    /// Of a world of `uavs` UAVs.
    ///
    /// # Errors
    /// More UAVs than a link serves.
    pub fn new(s: &Settings, uavs: usize) -> Result<Self, RadioError> {
        Ok(if s.lossy() {
            Self::Linked(Box::new(RadioObserver::new(uavs)?))
        } else {
            Self::Perfect(Observer::new(0, s.tie_period))
        })
    }

    /// A new episode with this policy seed.
    ///
    /// # Panics
    /// When `radio_loss` is outside its bounds.
    pub fn begin(&mut self, s: &Settings, policy_seed: u64) {
        match self {
            Self::Perfect(observer) => *observer = Observer::new(policy_seed, s.tie_period),
            Self::Linked(observer) => {
                observer.begin(policy_seed, s.tie_period, &draw(s, policy_seed)).expect("a link within the bounds");
            }
        }
    }

    /// Writes observations and kept neighbours of the present state. Call it once a step.
    pub fn observe(&mut self, world: &World, out: ObservationSliceMut<'_>, links: &mut [Neighbourhood]) {
        match out {
            ObservationSliceMut::Compact(out) => self.observe_as(world, out, links),
            ObservationSliceMut::Cells(out) => self.observe_as(world, out, links),
        }
    }

    fn observe_as<O: BuildObservation>(&mut self, world: &World, out: &mut [O], links: &mut [Neighbourhood]) {
        match self {
            Self::Perfect(observer) => observer.observe(world, out, links),
            Self::Linked(observer) => observer.observe(world, out, links),
        }
    }
}

/// The link of an episode.
fn draw(s: &Settings, policy_seed: u64) -> RadioSettings {
    let mut random = stream("training link", policy_seed, 0);
    let loss = s.radio_loss * unit(&mut random);
    let delay_ms = below(&mut random, s.radio_delay + 1) * u32::from(DEFAULT_STEP_MS);
    RadioSettings { loss, delay_ms, range_u: Some(REACH_U as f32), ..RadioSettings::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn episodes_draw_links_of_their_own_up_to_the_settings() {
        let s = Settings { radio_loss: 0.4, radio_delay: 2, ..Settings::default() };
        let links: Vec<_> = (0..500).map(|seed| draw(&s, seed)).collect();
        assert!(links.iter().all(|l| l.validate().is_ok() && l.loss <= 0.4));
        let mean = links.iter().map(|l| l.loss).sum::<f64>() / 500.0;
        assert!((mean - 0.2).abs() < 0.02, "{mean}");
        for delay_ms in [0, 2_000, 4_000] {
            let often = links.iter().filter(|l| l.delay_ms == delay_ms).count();
            assert!(often.abs_diff(167) < 40, "{delay_ms} ms: {often}");
        }
    }

    #[test]
    fn a_run_without_a_link_sees_everything() {
        assert!(matches!(Eyes::new(&Settings::default(), 20), Ok(Eyes::Perfect(_))));
        for s in
            [Settings { radio_loss: 0.1, ..Settings::default() }, Settings { radio_delay: 1, ..Settings::default() }]
        {
            assert!(matches!(Eyes::new(&s, 20), Ok(Eyes::Linked(_))));
        }
    }
}
