//! Evaluation over a radio channel.

use super::error::RadioError;
use super::error::RadioWorldError;
use super::figures::RadioFigures;
use super::policy::RadioPolicy;
use crate::evaluation::{Evaluation, rollout};
use crate::scenario::Scenario;
use crate::world::World;
use firmware_core::actor::ActorInput;
use rayon::prelude::*;

/// [`crate::evaluate`] with a policy that flies over a radio channel; returns what the channel did, too. `policy_seed`
/// gives the policy seed of the world of an index; `on_state` sees every state, the spawn states too. The result does not
/// depend on the number of threads.
///
/// # Errors
/// [`RadioWorldError`] when the scenario is not valid or the policy is for another number of UAVs.
pub fn evaluate_over_radio<O: ActorInput>(
    scenario: &Scenario,
    seed: u64,
    worlds: u64,
    policy: &RadioPolicy<'_, O>,
    policy_seed: impl Fn(u64) -> u64 + Sync,
    on_state: impl Fn(&World) + Sync,
) -> Result<(Evaluation, RadioFigures), RadioWorldError> {
    let fresh = World::new(scenario)?;
    let nodes = policy.channel().nodes();
    if nodes != scenario.uavs {
        return Err(RadioError::OtherNodes { nodes, uavs: scenario.uavs }.into());
    }
    let flown = (0..worlds).into_par_iter().map_init(
        || (fresh.clone(), policy.clone()),
        |(world, policy), index| {
            world.reset(seed, index);
            policy.reseed(policy_seed(index));
            rollout(world, policy, &on_state);
            (world.metrics(), policy.figures())
        },
    );
    let (worlds, figures): (Vec<_>, Vec<_>) = flown.unzip();
    Ok((Evaluation { worlds }, figures.into_iter().fold(RadioFigures::default(), RadioFigures::plus)))
}
