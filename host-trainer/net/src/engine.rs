//! The interface of devices that compute the networks, such as GPUs.

use crate::actor_critic::ActorCritic;
use crate::matrix::Rows;
use covey_env::Neighbourhood;
use firmware_core::action::ACTIONS;
use firmware_core::observation::Observation;
use thiserror::Error;

/// The observations and communication graphs of some world-steps (a world at a step each).
#[derive(Clone, Copy, Debug)]
pub struct GraphBatch<'s> {
    /// UAVs in a world, the same number in all batches of a call.
    pub uavs: usize,
    /// An observation in the compact form of every UAV, world-step by world-step.
    pub observations: &'s [Observation],
    /// The kept neighbours of every UAV, as indices into its world, likewise.
    pub neighbours: &'s [Neighbourhood],
}

impl GraphBatch<'_> {
    /// Number of world-steps.
    #[must_use]
    pub const fn world_steps(&self) -> usize {
        self.neighbours.len() / self.uavs
    }
}

/// Logits and normalised values of some world-steps, a row a UAV; after the loss, in their places,
/// the gradients by them.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// Logits, 17 wide.
    pub logits: Rows,
    /// Normalised values, 1 wide.
    pub values: Rows,
}

impl Default for Outputs {
    fn default() -> Self {
        Self { logits: Rows::new(ACTIONS), values: Rows::new(1) }
    }
}

/// Why a device cannot compute the networks.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EngineError {
    /// The device gave up: most often its memory is full.
    #[error("{device} failed: {why}; with a smaller `num_envs` or `minibatch` it needs less memory")]
    Failed {
        /// Its name.
        device: String,
        /// What it said.
        why: String,
    },
    /// Devices do not take such a run.
    #[error("networks on {device} train with `{setting}` only: set that, or train with `--device cpu`")]
    Unsupported {
        /// Its name.
        device: String,
        /// The one setting that it takes.
        setting: &'static str,
    },
    /// Its numbers are not those that the CPU computes.
    #[error("{device} computes {what} wrong (off by {error:.1e} of the greatest): train with `--device cpu`")]
    Wrong {
        /// Its name.
        device: String,
        /// Which numbers.
        what: &'static str,
        /// Greatest difference over the greatest number.
        error: f32,
    },
}

/// A device that computes both networks of many world-steps at once.
///
/// Parameters and gradients cross this interface as the flat vectors of
/// [`ParameterLayout`](crate::ParameterLayout); loss and optimiser stay with the caller.
pub trait Engine: Send {
    /// Name of the device, for messages.
    fn name(&self) -> String;

    /// Takes the parameters of actor and critic.
    fn load_parameters(&mut self, parameters: ActorCritic<&[f32]>);

    /// Computes logits and values of all world-steps, in their order.
    ///
    /// # Errors
    /// When the device fails.
    fn forward(&mut self, batches: &[GraphBatch<'_>], out: &mut Outputs) -> Result<(), EngineError>;

    /// Takes the world-steps of a rollout for [`Self::gradient`], instead of those before.
    fn load_rollout(&mut self, batches: &[GraphBatch<'_>]);

    /// Computes the gradients of a loss of some of the rollout's world-steps, which are numbered in
    /// the order of [`Self::load_rollout`]. `loss` is given their outputs and writes the gradients
    /// by them in their place.
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
