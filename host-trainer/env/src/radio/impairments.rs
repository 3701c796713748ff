//! Losses and bit errors.

use super::datagram_random::DatagramRandom;
use super::settings::RadioSettings;

/// Most bits that are flipped in a corrupted datagram.
const MAX_FLIPS: u32 = 4;

/// The state of one direction: from one sender to one receiver.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Direction {
    /// Datagrams sent in range.
    pub sequence: u32,
    /// Whether the Gilbert-Elliott model is in its bad state, in which it loses everything.
    pub in_bad_state: bool,
    /// Whether a datagram is held back.
    pub holds: bool,
}

/// Whether the next datagram of a direction is lost: independently, or by the Gilbert-Elliott model.
pub(super) fn is_lost(
    settings: &RadioSettings,
    direction: &mut Direction,
    sequence: u32,
    random: &mut DatagramRandom,
) -> bool {
    let RadioSettings { loss, burst, .. } = *settings;
    let probability = match burst {
        Some(burst) if sequence > 0 && loss < 1.0 => match direction.in_bad_state {
            true => 1.0 - 1.0 / burst,
            // Chosen so that in the long run the share `loss` is lost.
            false => loss / (1.0 - loss) / burst,
        },
        _ => loss,
    };
    direction.in_bad_state = random.happens(probability);
    direction.in_bad_state
}

/// Flips 1 to [`MAX_FLIPS`] different bits (or as many as there are).
pub(super) fn flip_bits(bytes: &mut [u8], random: &mut DatagramRandom) {
    let bits = u32::try_from(bytes.len() * 8).unwrap_or(u32::MAX);
    let flips = (1 + random.below(MAX_FLIPS)).min(bits);
    let mut flipped = [u32::MAX; MAX_FLIPS as usize];
    for k in 0..flips as usize {
        let mut bit = random.below(bits);
        while flipped[..k].contains(&bit) {
            bit = (bit + 1) % bits;
        }
        flipped[k] = bit;
        bytes[bit as usize / 8] ^= 1 << (bit % 8);
    }
}
