//! An actor file of either form of the observation.

use firmware_core::actor::{Actor, Aggregation, CellsActor, LoadError, SelfTestError};
use firmware_core::observation::cells;
use thiserror::Error;

/// A loaded actor of either form of the observation. It reads its weights from the file's bytes.
#[derive(Clone, Copy, Debug)]
pub enum AnyActor<'a> {
    /// It observes in the compact form.
    Compact(Actor<'a>),
    /// It observes cells.
    Cells(CellsActor<'a>),
}

/// Why an actor must not fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum UnsoundActor {
    /// The bytes are no sound actor file.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The actor does not compute here what it computed where it was made.
    #[error(transparent)]
    SelfTest(#[from] SelfTestError),
}

/// Does the same with an [`AnyActor`] of either form: `with_actor!(any, actor => …)`, where
/// `actor` is a reference to the one inside.
macro_rules! with_actor {
    ($any:expr, $actor:ident => $do:expr) => {
        match &$any {
            $crate::eval::AnyActor::Compact($actor) => $do,
            $crate::eval::AnyActor::Cells($actor) => $do,
        }
    };
}
pub(crate) use with_actor;

impl<'a> AnyActor<'a> {
    /// Reads an actor file in place, without running its self-test.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn load(file: &'a [u8]) -> Result<Self, LoadError> {
        match Actor::load(file) {
            Err(LoadError::Observation { found: cells::ID, .. }) => CellsActor::load(file).map(Self::Cells),
            loaded => loaded.map(Self::Compact),
        }
    }

    /// Reads an actor file in place and runs its self-test: what has to be done before a flight.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn load_tested(file: &'a [u8]) -> Result<Self, UnsoundActor> {
        let actor = Self::load(file)?;
        actor.self_test()?;
        Ok(actor)
    }

    /// Recomputes the file's self-test vectors.
    ///
    /// # Errors
    /// The first vector whose logits differ.
    pub fn self_test(&self) -> Result<(), SelfTestError> {
        with_actor!(*self, actor => actor.self_test())
    }

    /// How it combines neighbours' features.
    #[must_use]
    pub const fn aggregation(&self) -> Aggregation {
        with_actor!(*self, actor => actor.aggregation())
    }
}
