//! What is refused about a radio channel.

use super::parameters::{KEYS, MAX_DELAY_MS, MAX_NODES};
use crate::scenario::ScenarioError;

/// Why there is no such radio channel, or no such swarm on it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RadioError {
    /// A probability outside 0 to 1, or not a number.
    #[error("radio: {key} = {value} is not a probability; use 0 to 1")]
    Probability {
        /// Which setting.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// A mean burst length below that of independent losses, or not a finite number.
    #[error(
        "radio: burst = {burst} with loss = {loss}; independent losses come {least:.2} in a row: use more or leave it out"
    )]
    Burst {
        /// Mean length asked for.
        burst: f64,
        /// Share lost.
        loss: f64,
        /// Shortest mean length.
        least: f64,
    },
    /// A delay or a jitter that is too long.
    #[error("radio: {key} = {ms}; use up to {MAX_DELAY_MS} ms")]
    Long {
        /// Which setting.
        key: &'static str,
        /// Its value, ms.
        ms: u32,
    },
    /// A range below zero, or not a number.
    #[error("radio: range_u = {0}; use a number above 0, or leave it out to reach everywhere")]
    Range(f32),
    /// No nodes, or more than [`MAX_NODES`].
    #[error("radio: {0} nodes; use 1 to {max}", max = MAX_NODES)]
    Nodes(usize),
    /// A policy that was made for another number of UAVs.
    #[error("radio: made for {nodes} UAVs, the scenario has {uavs}; make it for as many")]
    OtherNodes {
        /// UAVs it was made for.
        nodes: usize,
        /// UAVs in the scenario.
        uavs: usize,
    },
    /// A part of the text is not `key=value`.
    #[error("radio: `{0}` is not key=value; an example is loss=0.1,burst=3,delay_ms=2000")]
    Syntax(String),
    /// No setting of this name.
    #[error("radio: no setting `{0}`; there are {keys}", keys = KEYS.join(", "))]
    Unknown(String),
    /// A setting that comes twice.
    #[error("radio: `{0}` is set twice")]
    Twice(&'static str),
    /// A value that is no number.
    #[error("radio: {key} = `{value}` is not a number of this kind")]
    Value {
        /// Which setting.
        key: &'static str,
        /// Its value.
        value: String,
    },
}

/// Why there is no such evaluation or training over a radio channel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RadioWorldError {
    /// The scenario is not valid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The radio channel is not valid.
    #[error(transparent)]
    Radio(#[from] RadioError),
}
