//! Observations over a link, for training.

use super::settings::{RadioError, RadioSettings};
use super::swarm::Swarm;
use crate::observer::Neighbourhood;
use crate::world::World;
use firmware_core::actor::PolicyId;
use firmware_core::message::FeatureMessage;
use firmware_core::observation::BuildObservation;
use firmware_core::random::tie_breaker;

/// Features of one number stand for those of a policy that is still learning: they travel, get
/// lost and grow old like any.
const POLICY: PolicyId = PolicyId { hash: 0, width: 1 };

/// Builds the observations of a world as UAVs have them over a link: [`crate::Observer`] for a
/// radio that is not perfect. Over a perfect one that reaches 34 u or farther both are the same.
#[derive(Clone, Debug)]
pub struct RadioObserver {
    swarm: Swarm,
    policy_seed: u64,
    tie_period: u32,
}

impl RadioObserver {
    /// For `uavs` UAVs, over a perfect link until [`Self::begin`] is told of another.
    ///
    /// # Errors
    /// More UAVs than a link has nodes.
    pub fn new(uavs: usize) -> Result<Self, RadioError> {
        let swarm = Swarm::new(&RadioSettings::default(), uavs, POLICY)?;
        Ok(Self { swarm, policy_seed: 0, tie_period: 1 })
    }

    /// Begins an episode: nobody has heard anything. Tie-breakers are drawn from `policy_seed`
    /// anew every `tie_period` steps (0 counts as 1), and the link's draws come from it too.
    ///
    /// # Errors
    /// Settings that cannot be; nothing has changed then.
    pub fn begin(&mut self, policy_seed: u64, tie_period: u32, link: &RadioSettings) -> Result<(), RadioError> {
        self.swarm.radio.retune(link)?;
        self.swarm.begin(policy_seed);
        (self.policy_seed, self.tie_period) = (policy_seed, tie_period);
        Ok(())
    }

    /// Writes the observation of every UAV in the present state, and the neighbours that it
    /// believes in range and whose feature it has, be it late. Call it once a step.
    ///
    /// # Panics
    /// When `out`, `links` or the swarm has not one entry a UAV.
    pub fn observe<O: BuildObservation>(&mut self, world: &World, out: &mut [O], links: &mut [Neighbourhood]) {
        let uavs = world.scenario().uavs;
        assert!(
            out.len() == uavs && links.len() == uavs,
            "observe: one observation and one Neighbourhood for each UAV"
        );
        let (seed, period, step) = (self.policy_seed, self.tie_period, world.steps_done());
        let tie = |id, step| tie_breaker(seed, id, step, period);
        self.swarm
            .look(world, tie, out, |seen| FeatureMessage::new(seen.header, seen.degree, POLICY.hash, 0, &[0]).ok());
        for (links, board) in links.iter_mut().zip(&self.swarm.boards) {
            *links = Neighbourhood::default();
            // Damage makes ids that nobody has.
            let ids = board.table.features(&board.view, step).map(|(id, _)| id).filter(|&id| usize::from(id) < uavs);
            for (to, id) in links.to.iter_mut().zip(ids) {
                *to = id;
                links.count += 1;
            }
        }
    }
}
