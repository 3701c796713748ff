//! Pairs of things that actor and critic both have.

/// The same thing of actor and critic: their layouts, parameters or gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActorCritic<T> {
    /// The actor's.
    pub actor: T,
    /// The critic's.
    pub critic: T,
}

impl<T> ActorCritic<T> {
    /// What `f` makes of each.
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> ActorCritic<U> {
        ActorCritic { actor: f(self.actor), critic: f(self.critic) }
    }

    /// References to both.
    pub const fn as_ref(&self) -> ActorCritic<&T> {
        ActorCritic { actor: &self.actor, critic: &self.critic }
    }
}
