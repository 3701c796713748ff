//! An actor file of either form of the observation.

use firmware_core::actor::{Actor, Aggregation, CellsActor, LoadError, SelfTestError};
use firmware_core::observation::cells;

/// A loaded actor of either form.
#[derive(Clone, Copy, Debug)]
pub enum AnyActor<'a> {
    /// It observes in the compact form.
    Compact(Actor<'a>),
    /// It observes cells.
    Cells(CellsActor<'a>),
}

/// Does the same with an [`AnyActor`] of either form: `with_actor!(any, actor => …)`, where
/// `actor` is a reference to the one inside.
#[macro_export]
macro_rules! with_actor {
    ($any:expr, $actor:ident => $do:expr) => {
        match &$any {
            $crate::any_actor::AnyActor::Compact($actor) => $do,
            $crate::any_actor::AnyActor::Cells($actor) => $do,
        }
    };
}

impl<'a> AnyActor<'a> {
    /// Reads an actor file in place.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn load(file: &'a [u8]) -> Result<Self, LoadError> {
        match Actor::load(file) {
            Err(LoadError::Observation { found: cells::ID, .. }) => CellsActor::load(file).map(Self::Cells),
            loaded => loaded.map(Self::Compact),
        }
    }

    /// Recomputes the file's self-test vectors.
    ///
    /// # Errors
    /// The first vector whose logits differ.
    pub fn self_test(&self) -> Result<(), SelfTestError> {
        with_actor!(*self, actor => actor.self_test())
    }

    /// How it aggregates.
    #[must_use]
    pub const fn aggregation(&self) -> Aggregation {
        with_actor!(*self, actor => actor.aggregation())
    }
}
