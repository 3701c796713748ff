//! The feature message: what a UAV's encoder made of its observation.

use super::error::MessageError;
use super::header::Header;
use crate::actor::{ActorInput, Feature, MAX_DEGREE, MAX_FEATURE, QuantisedActor};
use heapless::Vec;

/// What a UAV's encoder made of its observation. Made by [`FeatureMessage::new`], so
/// every one can be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FeatureMessage {
    pub(super) header: Header,
    pub(super) degree: u8,
    pub(super) actor: u32,
    pub(super) attention_source: i16,
    pub(super) values: Vec<i8, MAX_FEATURE>,
}

impl FeatureMessage {
    /// A feature of 1 to [`MAX_FEATURE`] `values`.
    ///
    /// `degree` is the number of neighbours kept plus one for the sender itself (1 to
    /// [`MAX_DEGREE`]), `actor` the content hash of the policy, `attention_source` the sender's
    /// half of the attention score (0 where the policy has none).
    ///
    /// # Errors
    /// [`MessageError::Degree`] or [`MessageError::Width`] when one is out of range.
    pub fn new(
        header: Header,
        degree: u8,
        actor: u32,
        attention_source: i16,
        values: &[i8],
    ) -> Result<Self, MessageError> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(MessageError::Degree(degree));
        }
        let width = u8::try_from(values.len()).unwrap_or(u8::MAX);
        match Vec::from_slice(values) {
            Ok(values) if !values.is_empty() => Ok(Self { header, degree, actor, attention_source, values }),
            _ => Err(MessageError::Width(width)),
        }
    }

    /// What a UAV with this policy, own feature and degree (itself included, taken as 1 to
    /// [`MAX_DEGREE`]) broadcasts; `None` when the policy uses no features of others.
    #[must_use]
    pub fn from_actor<O: ActorInput>(
        header: Header,
        degree: u8,
        actor: &QuantisedActor<'_, O>,
        own: &Feature,
    ) -> Option<Self> {
        let width = usize::from(actor.policy_id().width);
        let values = own.values.get(..width)?;
        Self::new(header, degree.clamp(1, MAX_DEGREE), actor.message_hash(), own.attention_source, values).ok()
    }

    /// Who sent it and when.
    #[must_use]
    pub const fn header(&self) -> Header {
        self.header
    }

    /// The sender's neighbours kept plus itself, 1 to [`MAX_DEGREE`].
    #[must_use]
    pub const fn degree(&self) -> u8 {
        self.degree
    }

    /// Content hash of the policy that made it: features of two policies do not mix.
    #[must_use]
    pub const fn actor(&self) -> u32 {
        self.actor
    }

    /// The sender's half of the attention score; 0 where the policy has none.
    #[must_use]
    pub const fn attention_source(&self) -> i16 {
        self.attention_source
    }

    /// The values, 1 to [`MAX_FEATURE`] of them.
    #[must_use]
    pub fn values(&self) -> &[i8] {
        &self.values
    }
}
