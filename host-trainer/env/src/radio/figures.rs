//! What a radio channel did to a swarm.

use super::counts::DatagramCounts;
use firmware_core::neighbour_table::MessageOutcome;
use firmware_core::observation::MAX_NEIGHBOURS;
use serde::{Deserialize, Serialize};

/// What a radio channel did to a swarm: sums over steps and UAVs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RadioFigures {
    /// What happened to the datagrams.
    pub counts: DatagramCounts,
    /// Messages that neighbour tables accepted.
    pub taken: u64,
    /// Messages that neighbour tables refused: too old, repeated, from too far away and so on.
    pub refused: u64,
    /// Datagrams that could not be decoded.
    pub malformed: u64,
    /// Neighbours truly in communication range, at most [`MAX_NEIGHBOURS`] for each UAV.
    pub neighbours: u64,
    /// Neighbours that their UAV believed in range and that were.
    pub known: u64,
    /// Neighbours that their UAV believed in range and that were not.
    pub ghosts: u64,
    /// Neighbours believed in range (ghosts included) whose feature their UAV had.
    pub features: u64,
}

impl RadioFigures {
    /// Counts a neighbour table's answer to a message.
    pub(super) fn add_answer(&mut self, answer: MessageOutcome) {
        *(if answer.is_taken() { &mut self.taken } else { &mut self.refused }) += 1;
    }

    /// Counts what one UAV believes: `neighbours` are truly in range; it believes in as many as `believed` has entries,
    /// each true when that one is in range; and it has `features` of them.
    pub(super) fn add_belief(&mut self, neighbours: usize, believed: impl Iterator<Item = bool>, features: usize) {
        self.neighbours += neighbours.min(MAX_NEIGHBOURS) as u64;
        believed.for_each(|in_range| *(if in_range { &mut self.known } else { &mut self.ghosts }) += 1);
        self.features += features as u64;
    }

    /// The sum of two, for example of two worlds.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            counts: self.counts.plus(other.counts),
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
