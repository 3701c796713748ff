//! Both networks as products read them, and what a part of the work needs beside them.

use super::ppo::Sample;
use covey_env::{Neighbourhood, ObservationSlice};
use covey_net::{ActorGradient, ActorNet, ActorPass, CriticGradient, CriticNet, CriticPass, Inputs, ParameterLayout};
use firmware_core::actor::Aggregation;

/// Actor and critic with their present parameters.
#[derive(Clone, Debug)]
pub struct Networks {
    /// The actor.
    pub actor: ActorNet,
    /// The critic.
    pub critic: CriticNet,
}

impl Networks {
    /// For these layouts, of actor and critic.
    #[must_use]
    pub fn new(layouts: &[ParameterLayout; 2], aggregation: Aggregation) -> Self {
        Self { actor: ActorNet::new(&layouts[0], aggregation), critic: CriticNet::new(&layouts[1]) }
    }
}

/// Buffers of one shard's work, kept from update to update.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// What a pass sees.
    pub inputs: Inputs,
    /// The actor's activations.
    pub actor: ActorPass,
    /// The critic's activations.
    pub critic: CriticPass,
    /// Sums of gradients.
    pub sums: (ActorGradient, CriticGradient),
    /// These as flat vectors.
    pub gradients: [Vec<f32>; 2],
    /// Samples of a pass.
    pub samples: Vec<Sample>,
    /// Multiply-adds of the updates, those with a zero left out; counted if there is a sum.
    pub counted: Option<u64>,
    /// Random numbers of a pass.
    pub draws: Vec<f64>,
}

impl Workspace {
    /// For networks of these layouts, which take such inputs.
    #[must_use]
    pub fn new(layouts: &[ParameterLayout; 2], inputs: Inputs) -> Self {
        Self {
            inputs,
            actor: ActorPass::new(&layouts[0]),
            critic: CriticPass::new(&layouts[1]),
            sums: (ActorGradient::new(&layouts[0]), CriticGradient::new(&layouts[1])),
            gradients: [0, 1].map(|k: usize| vec![0.0; layouts[k].len()]),
            samples: Vec::new(),
            counted: None,
            draws: Vec::new(),
        }
    }

    /// Takes in what all UAVs of some worlds of `uavs` see.
    pub fn see(&mut self, uavs: usize, observations: ObservationSlice<'_>, links: &[Neighbourhood]) {
        self.inputs.clear(uavs);
        self.inputs.push(observations, links);
    }
}
