//! Observations over a radio channel, for training.

use super::error::RadioError;
use super::settings::RadioSettings;
use super::swarm::Swarm;
use crate::observe::{Neighbourhood, assert_one_each};
use crate::world::World;
use firmware_core::actor::{Mode, PolicyId};
use firmware_core::agent::{Agent, AgentSettings};
use firmware_core::geometry::{MAP_SIDE_U, TICKS_PER_U};
use firmware_core::message::{FeatureMessage, Header};
use firmware_core::neighbour_table::DEFAULT_STEP_MS;
use firmware_core::observation::BuildObservation;

/// Features of one number stand for those of a policy in training: they are sent, lost and outdated like any.
const POLICY: PolicyId = PolicyId { hash: 0, width: 1 };

/// Builds the observations of a world as its UAVs have them over a radio channel: [`crate::Observer`] with losses and
/// delays. Over a perfect channel that reaches 34 u or farther both give the same.
#[derive(Clone, Debug)]
pub struct RadioObserver {
    swarm: Swarm,
}

impl RadioObserver {
    /// An observer for `uavs` UAVs, over a perfect channel until [`Self::begin`] sets another.
    ///
    /// # Errors
    /// [`RadioError::Nodes`] when there are no UAVs, or more than a channel has nodes.
    pub fn new(uavs: usize) -> Result<Self, RadioError> {
        let shared = AgentSettings {
            id: 0,
            policy: POLICY,
            tie_period: 1,
            policy_seed: 0,
            mode: Mode::Sample,
            step_ms: DEFAULT_STEP_MS,
            half_side: MAP_SIDE_U as i32 * TICKS_PER_U / 2,
        };
        Ok(Self { swarm: Swarm::new(&RadioSettings::default(), uavs, shared)? })
    }

    /// Begins an episode: neighbour tables are empty. Tie-breakers are drawn from `policy_seed` anew every `tie_period`
    /// steps (0 counts as 1), and the channel's random numbers follow from it too.
    ///
    /// # Errors
    /// [`RadioError`] when a parameter is out of range; nothing has changed then.
    pub fn begin(&mut self, policy_seed: u64, tie_period: u32, settings: &RadioSettings) -> Result<(), RadioError> {
        self.swarm.channel.set_settings(settings)?;
        self.swarm.begin(AgentSettings { policy_seed, tie_period, ..self.swarm.shared() });
        Ok(())
    }

    /// Writes the observation of every UAV in the present state, and as its neighbourhood those that it believes in
    /// range and whose feature it has, even if of an earlier step. Call it once for each step.
    ///
    /// # Panics
    /// When `observations`, `neighbourhoods` or the swarm has not one entry for each UAV.
    pub fn observe<O: BuildObservation>(
        &mut self,
        world: &World,
        observations: &mut [O],
        neighbourhoods: &mut [Neighbourhood],
    ) {
        let uavs = world.scenario().uavs;
        assert_one_each(observations, neighbourhoods, uavs);
        self.swarm.exchange(world, observations, |agent, _, sequence| feature_without_actor(agent, sequence));
        for (neighbourhood, agent) in neighbourhoods.iter_mut().zip(&self.swarm.agents) {
            // Bit errors make ids that no UAV has.
            *neighbourhood = agent.features().map(|(id, _)| id).filter(|&id| usize::from(id) < uavs).collect();
        }
    }
}

fn feature_without_actor(agent: &Agent, sequence: u16) -> Option<FeatureMessage> {
    let header = Header { id: agent.settings().id, sequence, step: agent.observed_step()? };
    FeatureMessage::new(header, agent.degree(), POLICY.hash, 0, &[0]).ok()
}
