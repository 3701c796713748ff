//! What a host asks of a board: postcard records.

use crate::geometry::{State, Vec2};
use crate::neighbour_table::Moment;
use serde::{Deserialize, Serialize};

/// What a host asks. The order of the variants is part of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request<'a> {
    /// Starts, or starts afresh with an empty neighbour table. Answer: [`Reply::Report`](super::Reply::Report).
    Hello(Setup),
    /// A neighbour's message. Answer: [`Reply::Heard`](super::Reply::Heard).
    #[serde(borrow)]
    Hear(Hear<'a>),
    /// Builds the observation of a step and encodes it. Answer: [`Reply::Observed`](super::Reply::Observed).
    Observe(Observe<'a>),
    /// Decides the step that was observed last. Answer: [`Reply::Decided`](super::Reply::Decided).
    Decide {
        /// The step.
        step: u32,
    },
    /// Answer: [`Reply::Status`](super::Reply::Status).
    Status,
    /// Runs the actor's self-test again. Answer: [`Reply::Report`](super::Reply::Report).
    SelfTest,
    /// Goes on with the actor's signature, from 0 cases anew. Answer: [`Reply::Signature`](super::Reply::Signature).
    Sign {
        /// Cases so far; a board that has another number says so and adds none.
        from: u32,
        /// Cases to add, at most [`super::MAX_CASES`].
        cases: u16,
    },
}

/// Whom the board flies for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// Its id in the swarm.
    pub id: u16,
    /// Seed of tie-breakers and sampled actions.
    pub seed: u64,
    /// Always the action with the greatest logit, instead of sampling.
    pub argmax: bool,
    /// Length of a step, ms (see [`crate::neighbour_table::NeighbourTable::new`]).
    pub step_ms: u16,
    /// Half the side of the map, ticks.
    pub half_side: i32,
}

/// A neighbour's message as the radio brought it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hear<'a> {
    /// When it was heard.
    pub now: Moment,
    /// Own position then, x and y, ticks.
    pub position: [i32; 2],
    /// The message, see [`crate::message`].
    pub message: &'a [u8],
}

/// What a UAV measures at a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observe<'a> {
    /// The step and its time.
    pub now: Moment,
    /// Own position, x and y, ticks.
    pub position: [i32; 2],
    /// Own velocity, x and y, ticks/step.
    pub velocity: [i32; 2],
    /// PoIs in view, up to [`super::MAX_POIS`] of [`super::POI_BYTES`] bytes.
    pub pois: &'a [u8],
}

impl Observe<'_> {
    /// Own state.
    #[must_use]
    pub const fn own(&self) -> State {
        let ([x, y], [vx, vy]) = (self.position, self.velocity);
        State { position: Vec2::from_ticks(x, y), velocity: Vec2::from_ticks(vx, vy) }
    }
}
