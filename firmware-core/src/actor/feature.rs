//! Features: what UAVs compute from their observations and tell each other.

use crate::observation::MAX_NEIGHBOURS;

/// Greatest width of a feature.
pub const MAX_FEATURE: usize = 64;
/// Greatest degree: a full table and the UAV itself.
pub const MAX_DEGREE: u8 = MAX_NEIGHBOURS as u8 + 1;

/// What a UAV computes from its own observation: [`Self::values`] and [`Self::attention_source`] to
/// broadcast, the rest to keep. Of each vector the actor's feature width is used; the rest is
/// zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Feature {
    /// `h`, which the head takes; kept at home.
    pub own: [i8; MAX_FEATURE],
    /// What others combine, broadcast: `h` again, but with GATv2 `W_r h`.
    pub values: [i8; MAX_FEATURE],
    /// GAT: the receiver's half of the score, kept at home (0 otherwise).
    pub attention_destination: i16,
    /// GAT: the sender's half of the score, broadcast (0 otherwise).
    pub attention_source: i16,
}

/// A neighbour's feature as it was received.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourFeature<'f> {
    /// What it broadcast: `h`, or with GATv2 `W_r h`.
    pub values: &'f [i8],
    /// The sender's degree, itself included, 1 to [`MAX_DEGREE`].
    pub degree: u8,
    /// The sender's half of the GAT score.
    pub attention_source: i16,
}
