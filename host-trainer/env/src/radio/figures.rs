//! What a link did to a swarm, and the coverage that was left.

use super::model::Counts;
use super::policy::RadioPolicy;
use super::settings::RadioError;
use crate::evaluate::{Evaluation, fly};
use crate::scenario::{Scenario, ScenarioError};
use crate::world::World;
use firmware_core::actor::ActorInput;
use firmware_core::neighbour_table::MessageOutcome;
use firmware_core::observation::MAX_NEIGHBOURS;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What a link did to a swarm: sums over steps and UAVs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RadioFigures {
    /// What became of the datagrams.
    pub counts: Counts,
    /// Messages that neighbour tables took.
    pub taken: u64,
    /// Messages that they refused: late, repeated, of too far a neighbour and so on.
    pub refused: u64,
    /// Datagrams that were no message.
    pub malformed: u64,
    /// Neighbours in communication range, [`MAX_NEIGHBOURS`] a UAV at most.
    pub neighbours: u64,
    /// How many of them their UAV knew of.
    pub known: u64,
    /// Neighbours that a UAV believed in range and that were not.
    pub ghosts: u64,
    /// Neighbours believed in range, ghosts too, of whom a feature was at hand.
    pub features: u64,
}

impl RadioFigures {
    /// Adds a message's fate.
    pub(super) fn add_answer(&mut self, answer: MessageOutcome) {
        *(if answer.is_taken() { &mut self.taken } else { &mut self.refused }) += 1;
    }

    /// Adds what one UAV knows: it has this many neighbours and believes in these, each in
    /// range or not, of `features` of whom it has a feature.
    pub(super) fn add_view(&mut self, neighbours: usize, believed: impl Iterator<Item = bool>, features: usize) {
        self.neighbours += neighbours.min(MAX_NEIGHBOURS) as u64;
        believed.for_each(|in_range| *(if in_range { &mut self.known } else { &mut self.ghosts }) += 1);
        self.features += features as u64;
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let (a, b) = (self.counts, other.counts);
        let counts = Counts {
            sent: a.sent + b.sent,
            out_of_range: a.out_of_range + b.out_of_range,
            lost: a.lost + b.lost,
            duplicated: a.duplicated + b.duplicated,
            held: a.held + b.held,
            corrupted: a.corrupted + b.corrupted,
            delivered: a.delivered + b.delivered,
        };
        Self {
            counts,
            taken: self.taken + other.taken,
            refused: self.refused + other.refused,
            malformed: self.malformed + other.malformed,
            neighbours: self.neighbours + other.neighbours,
            known: self.known + other.known,
            ghosts: self.ghosts + other.ghosts,
            features: self.features + other.features,
        }
    }
}

/// Why an evaluation over a link cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RadioWorldError {
    /// No such worlds.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// No such link.
    #[error(transparent)]
    Link(#[from] RadioError),
}

/// [`crate::evaluate`] with a policy that flies over a link, and what the link did.
/// `policy_seed` gives the policy's seed in the world of an index. The result does not depend
/// on the number of threads.
///
/// # Errors
/// When the scenario is not valid or the policy made for another number of UAVs.
pub fn evaluate_over<O: ActorInput>(
    scenario: &Scenario,
    seed: u64,
    worlds: u64,
    policy: &RadioPolicy<'_, O>,
    policy_seed: impl Fn(u64) -> u64 + Sync,
) -> Result<(Evaluation, RadioFigures), RadioWorldError> {
    let fresh = World::new(scenario)?;
    let nodes = policy.radio().nodes();
    if nodes != scenario.uavs {
        return Err(RadioError::OtherNodes { nodes, uavs: scenario.uavs }.into());
    }
    let flown = (0..worlds).into_par_iter().map_init(
        || (fresh.clone(), policy.clone()),
        |(world, policy), index| {
            world.reset(seed, index);
            policy.reseed(policy_seed(index));
            fly(world, policy, |_| {});
            (world.metrics(), policy.figures())
        },
    );
    let (worlds, figures): (Vec<_>, Vec<_>) = flown.unzip();
    Ok((Evaluation { worlds }, figures.into_iter().fold(RadioFigures::default(), RadioFigures::plus)))
}
