//! The parameters of the channel model.

use super::error::RadioError;
use super::parameters::MAX_DELAY_MS;
use serde::{Deserialize, Serialize};

/// Parameters of a radio channel. [`Default`] is the perfect one, which delivers every datagram at once.
///
/// In text (`FromStr`, `Display`) they are `key=value` with commas between, such as `loss=0.1,burst=3,delay_ms=2000`;
/// `perfect` stands for the default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RadioSettings {
    /// Probability that a datagram is lost, 0 to 1.
    pub loss: f64,
    /// Mean number of datagrams of one direction that are lost in a row, by the Gilbert-Elliott model whose good state
    /// loses nothing and whose bad state loses everything. At least 1/(1 − loss), the mean of independent losses;
    /// `None` for independent losses.
    pub burst: Option<f64>,
    /// Propagation delay, ms, up to ten minutes.
    pub delay_ms: u32,
    /// Jitter, ms, up to ten minutes: added to the delay of each datagram, uniform from 0 to this. So one datagram may
    /// overtake another.
    pub jitter_ms: u32,
    /// Probability that a datagram arrives twice, 0 to 1; the second copy has a jitter and bit errors of its own.
    pub duplicate: f64,
    /// Probability that a datagram is held back until the next one of the same direction has arrived, 0 to 1. At most
    /// one is held at a time, so at most every other one is.
    pub reorder: f64,
    /// Probability that a datagram arrives with 1 to 4 bits flipped, 0 to 1. The channel drops none for it: checksums
    /// are the business of sender and receiver.
    pub corrupt: f64,
    /// Range of the radio, u (the limit is inside); `None` for everywhere.
    pub range_u: Option<f32>,
}

impl RadioSettings {
    /// Checks every parameter.
    ///
    /// # Errors
    /// [`RadioError`] of the first parameter that is out of range.
    pub fn validate(&self) -> Result<(), RadioError> {
        let probabilities =
            [("loss", self.loss), ("duplicate", self.duplicate), ("reorder", self.reorder), ("corrupt", self.corrupt)];
        if let Some(&(key, value)) = probabilities.iter().find(|(_, v)| !(0.0..=1.0).contains(v)) {
            return Err(RadioError::Probability { key, value });
        }
        if let Some(burst) = self.burst {
            let least = 1.0 / (1.0 - self.loss);
            // Without losses, or without anything else, the mean burst length says nothing.
            let matters = self.loss > 0.0 && self.loss < 1.0;
            // The tolerance lets a rounded 1/(1 − loss) pass.
            if !burst.is_finite() || burst < 1.0 || (matters && burst < least - 0.005) {
                return Err(RadioError::Burst { burst, loss: self.loss, least });
            }
        }
        for (key, ms) in [("delay_ms", self.delay_ms), ("jitter_ms", self.jitter_ms)] {
            if ms > MAX_DELAY_MS {
                return Err(RadioError::Long { key, ms });
            }
        }
        match self.range_u {
            Some(range) if !(range.is_finite() && range > 0.0) => Err(RadioError::Range(range)),
            _ => Ok(()),
        }
    }
}
