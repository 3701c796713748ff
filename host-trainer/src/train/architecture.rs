//! Widths and parameter layouts of the networks.

use crate::settings::Settings;
use covey_net::{ActorCritic, ParameterLayout};
use firmware_core::action::ACTIONS;
use firmware_core::actor::Dimensions;

/// Widths of the networks for these settings.
#[must_use]
pub fn dimensions(s: &Settings) -> Dimensions {
    Dimensions {
        observation: s.observation.len() as u16,
        hidden: s.hidden,
        feature: s.feature,
        head: s.head,
        actions: ACTIONS as u16,
    }
}

/// Parameter layouts of networks that take the first `inputs` numbers of an observation.
pub fn layouts(s: &Settings, inputs: u16) -> ActorCritic<ParameterLayout> {
    let d = Dimensions { observation: inputs, ..dimensions(s) };
    ActorCritic { actor: ParameterLayout::actor(d, s.graph), critic: ParameterLayout::critic(d) }
}
