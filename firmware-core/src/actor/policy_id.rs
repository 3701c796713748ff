//! Which policy a UAV flies, as far as its swarm needs to know.

/// Identifies the policy whose features a UAV makes and takes: features of two policies do not
/// mix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolicyId {
    /// The hash that feature messages carry ([`QuantisedActor::message_hash`]).
    ///
    /// [`QuantisedActor::message_hash`]: super::QuantisedActor::message_hash
    pub hash: u32,
    /// Values of a feature, up to [`MAX_FEATURE`](super::MAX_FEATURE); 0 when the policy uses
    /// no features of others.
    pub width: u8,
}
