//! How often the int8 actor would choose what the float policy chooses.

use super::config::EvalConfig;
use super::watch::Watch;
use crate::float_actor::{FloatActor, FloatPolicy, argmax};
use covey_env::{ActorPolicy, ScenarioError, World, policy_seed};
use firmware_core::action::Action;
use firmware_core::actor::{ActorInput, QuantisedActor, argmax as int8_argmax};
use rayon::prelude::*;

/// Decisions compared, and in how many the greatest logit is of the same action.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Agreement {
    /// Decisions in which both have the same greatest logit.
    pub agreeing: u64,
    /// All decisions compared.
    pub decisions: u64,
}

impl Agreement {
    /// Share of the decisions that agree, 0 to 1.
    #[must_use]
    pub fn share(self) -> f64 {
        self.agreeing as f64 / self.decisions as f64
    }
}

/// Compares the greatest logits of both in the very same situations: the int8 actor flies the
/// worlds, and the float policy is asked at every step what it would do. Tells `watch` how far it
/// is.
///
/// # Errors
/// When the scenario cannot be built.
pub fn argmax_agreement<O: ActorInput>(
    int8: &QuantisedActor<'_, O>,
    float: &FloatActor,
    config: &EvalConfig,
    watch: Watch<'_>,
) -> Result<Agreement, ScenarioError> {
    let fresh = World::new(&config.scenario)?;
    let net = float.network();
    let worlds = (0..u64::from(config.worlds)).into_par_iter().map(|index| {
        let mut world = fresh.clone();
        world.reset(config.seed, index);
        let seed = policy_seed(config.seed, index);
        let mut own = ActorPolicy::new(*int8, seed, config.mode);
        let mut other = FloatPolicy::new(float, &net, seed, config.mode);
        let mut actions = vec![Action::COAST; config.scenario.uavs];
        let mut agreeing = 0;
        while !world.done() {
            own.observe(&world);
            let logits = other.forward(&world).logits();
            for (i, action) in actions.iter_mut().enumerate() {
                let mine = own.logits(i);
                agreeing += u64::from(int8_argmax(&mine) == argmax(logits.row(i)));
                *action = own.choose(&mine, i, world.steps_done());
            }
            world.step(&actions);
            watch(actions.len() as u64);
        }
        agreeing
    });
    Ok(Agreement { agreeing: worlds.sum(), decisions: config.agent_steps() })
}
