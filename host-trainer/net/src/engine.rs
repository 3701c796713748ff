//! The seam behind which the networks may be computed elsewhere: on a GPU.

use crate::actor_critic::ActorCritic;
use crate::matrix::Rows;
use covey_env::Neighbourhood;
use firmware_core::action::ACTIONS;
use firmware_core::observation::Observation;
use thiserror::Error;

/// What all UAVs of some world-steps see: an observation and the neighbours of each.
#[derive(Clone, Copy, Debug)]
pub struct GraphBatch<'s> {
    /// UAVs in a world, the same in every one of a call.
    pub uavs: usize,
    /// Observations in the compact form, world-step by world-step.
    pub observations: &'s [Observation],
    /// Kept neighbours, as `observations`.
    pub neighbours: &'s [Neighbourhood],
}

impl GraphBatch<'_> {
    /// Number of world-steps.
    #[must_use]
    pub const fn world_steps(&self) -> usize {
        self.neighbours.len() / self.uavs
    }
}

/// Logits and normalised values of some world-steps, a row a UAV; in their places
/// afterwards, the gradient of the loss by them.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// 17 wide.
    pub logits: Rows,
    /// 1 wide.
    pub values: Rows,
}

impl Default for Outputs {
    fn default() -> Self {
        Self { logits: Rows::new(ACTIONS), values: Rows::new(1) }
    }
}

/// Why an engine is of no use.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EngineError {
    /// The device gave up: most often its memory is full.
    #[error("{device} failed: {why}; with a smaller `num_envs` or `minibatch` it needs less memory")]
    Failed {
        /// The engine.
        device: String,
        /// What it said.
        why: String,
    },
    /// It computes no such run.
    #[error("networks on {device} train with `{setting}` only: set that, or train with `--device cpu`")]
    Unsupported {
        /// The engine.
        device: String,
        /// The one setting that it takes.
        setting: &'static str,
    },
    /// Its numbers are not those of the networks by hand.
    #[error("{device} computes {what} wrong (off by {error:.1e} of the greatest): train with `--device cpu`")]
    Wrong {
        /// The engine.
        device: String,
        /// Which numbers.
        what: &'static str,
        /// Greatest difference over the greatest number.
        error: f32,
    },
}

/// Computes both networks of many world-steps in one go.
///
/// Parameters and gradients cross it as the flat vectors of [`ParameterLayout`](crate::ParameterLayout), actor
/// first; the optimiser stays on this side.
pub trait Engine: Send {
    /// What it computes on, for messages.
    fn name(&self) -> String;

    /// Takes the parameters of actor and critic.
    fn load(&mut self, parameters: ActorCritic<&[f32]>);

    /// Computes logits and values of world-steps, one after the other.
    ///
    /// # Errors
    /// When the device fails.
    fn forward(&mut self, seen: &[GraphBatch<'_>], out: &mut Outputs) -> Result<(), EngineError>;

    /// Keeps world-steps for [`Self::gradient`], instead of those it kept before.
    fn hold(&mut self, seen: &[GraphBatch<'_>]);

    /// The gradients of a loss of some of the held world-steps, which are numbered in their
    /// order. `loss` is given their outputs and writes the gradient by them in their place.
    ///
    /// # Errors
    /// When the device fails.
    fn gradient(
        &mut self,
        world_steps: &[u32],
        out: &mut Outputs,
        loss: &mut dyn FnMut(&mut Outputs),
        gradients: &mut ActorCritic<Vec<f32>>,
    ) -> Result<(), EngineError>;
}
