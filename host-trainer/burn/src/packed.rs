//! World-steps on the device as small as they come: observations as bytes, neighbours as bits.
//! What crosses to a GPU is 160 bytes and a few words an agent sample.

use crate::networks::{Batch, unpack_neighbours, unpack_observations};
use burn::tensor::{Device, Int, Tensor, TensorData};
use covey_env::Neighbourhood;
use covey_net::GraphBatch;
use firmware_core::observation::{LEN, Observation};

/// Words of four observed numbers each.
const OBSERVATION_WORDS: usize = LEN / 4;
const _: () = assert!(LEN.is_multiple_of(4), "whole words");

/// World-steps on a device.
pub struct Packed {
    uavs: usize,
    /// `[world-steps, N · words]`.
    observations: Tensor<2, Int>,
    /// `[world-steps, N · ⌈N/32⌉]`.
    neighbours: Tensor<2, Int>,
}

impl Packed {
    /// Brings world-steps to a device.
    ///
    /// # Panics
    /// When there are none, or not all of them have the same number of UAVs.
    pub fn new(batches: &[GraphBatch<'_>], device: &Device) -> Self {
        let uavs = batches.first().map_or(0, |b| b.uavs);
        assert!(uavs > 0 && batches.iter().all(|b| b.uavs == uavs), "world-steps of the same number of UAVs");
        let mut words = Vec::with_capacity(batches.iter().map(|b| b.observations.len() * OBSERVATION_WORDS).sum());
        let mut bits = Vec::new();
        for batch in batches {
            batch.observations.iter().for_each(|o| pack_observation(o, &mut words));
            batch.neighbours.chunks_exact(uavs).for_each(|world| pack_neighbours(world, &mut bits));
        }
        let world_steps = words.len() / (uavs * OBSERVATION_WORDS);
        let tensor = |words: Vec<i32>| {
            let width = words.len() / world_steps;
            Tensor::from_data(TensorData::new(words, [world_steps, width]), device)
        };
        Self { uavs, observations: tensor(words), neighbours: tensor(bits) }
    }

    /// Some of the world-steps.
    pub fn select(&self, world_steps: &[u32]) -> Self {
        let numbers: Vec<i32> = world_steps.iter().map(|&w| w as i32).collect();
        let numbers = Tensor::<1, Int>::from_data(TensorData::from(&numbers[..]), &self.observations.device());
        Self {
            uavs: self.uavs,
            observations: self.observations.clone().select(0, numbers.clone()),
            neighbours: self.neighbours.clone().select(0, numbers),
        }
    }

    /// As networks of this many inputs take them.
    pub fn unpack(&self, inputs: usize) -> Batch {
        let [world_steps, width] = self.neighbours.dims();
        let rows = world_steps * self.uavs;
        let observations = self.observations.clone().reshape([rows, OBSERVATION_WORDS]);
        let neighbours = self.neighbours.clone().reshape([rows, width / self.uavs]);
        Batch {
            world_steps,
            uavs: self.uavs,
            observations: unpack_observations(observations, inputs),
            neighbours: unpack_neighbours(neighbours, self.uavs),
        }
    }
}

/// Four numbers to a word, the first one lowest, each with 128 added so that it has no sign.
fn pack_observation(observation: &Observation, words: &mut Vec<i32>) {
    let (groups, _) = observation.as_chunks::<4>();
    words.extend(groups.iter().map(|g| i32::from_le_bytes(g.map(|v| (v as u8) ^ 0x80))));
}

/// A row of bits a UAV: itself and its neighbours.
fn pack_neighbours(world: &[Neighbourhood], words: &mut Vec<i32>) {
    let width = world.len().div_ceil(32);
    for (i, neighbours) in world.iter().enumerate() {
        let first = words.len();
        words.resize(first + width, 0);
        let ids = neighbours.as_slice().iter().map(|&j| usize::from(j)).chain([i]);
        ids.for_each(|j| words[first + j / 32] |= 1 << (j % 32));
    }
}
