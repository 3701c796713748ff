//! How a board and its line are.

use super::frame::FrameError;
use serde::{Deserialize, Serialize};

/// How the board and the line are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// Whether a [`Request::Hello`](super::Request::Hello) came.
    pub started: bool,
    /// The step observed last.
    pub observed: Option<u32>,
    /// UAVs in the neighbour table.
    pub kept: u8,
    /// Decisions since the start.
    pub decisions: u32,
    /// What came over the line.
    pub counters: Counters,
}

/// What came over the line since the board started; each number wraps around.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Requests carried out.
    pub done: u32,
    /// Requests refused, unreadable ones and other versions' included.
    pub refused: u32,
    /// See [`FrameError::TooLong`].
    pub too_long: u32,
    /// See [`FrameError::Broken`].
    pub broken: u32,
    /// See [`FrameError::TooShort`].
    pub too_short: u32,
    /// See [`FrameError::Checksum`].
    pub checksum: u32,
    /// See [`FrameError::Version`].
    pub version: u32,
}

impl Counters {
    /// Frames that were dropped.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.too_long.wrapping_add(self.broken).wrapping_add(self.too_short).wrapping_add(self.checksum)
    }

    pub(super) fn count(&mut self, error: FrameError) {
        let counter = match error {
            FrameError::TooLong => &mut self.too_long,
            FrameError::Broken => &mut self.broken,
            FrameError::TooShort => &mut self.too_short,
            FrameError::Checksum => &mut self.checksum,
            FrameError::Version(_) => &mut self.version,
        };
        *counter = counter.wrapping_add(1);
    }
}
