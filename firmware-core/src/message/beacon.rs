//! The beacon: where a UAV is.

use super::header::Header;
use crate::geometry::{State, Vec2};

/// Where a UAV is. Made by [`Beacon::new`], so every beacon can be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beacon {
    pub(super) header: Header,
    pub(super) time_ms: u32,
    pub(super) position: Vec2,
    pub(super) velocity: [i16; 2],
    pub(super) tie: i8,
}

impl Beacon {
    /// A beacon of the state measured at `time_ms` of the swarm's common clock.
    ///
    /// What the layout cannot hold becomes the nearest that it can: position ±
    /// [`COORDINATE_LIMIT`](crate::geometry::COORDINATE_LIMIT), velocity ± 32,767 ticks/step (32 u/step), tie-breaker ±127.
    #[must_use]
    pub fn new(header: Header, time_ms: u32, state: State, tie: i8) -> Self {
        let short = |v: i32| v.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
        Self {
            header,
            time_ms,
            position: Vec2::from_ticks(state.position.x, state.position.y),
            velocity: [short(state.velocity.x), short(state.velocity.y)],
            tie: tie.max(-127),
        }
    }

    /// Who sent it and when.
    #[must_use]
    pub const fn header(&self) -> Header {
        self.header
    }

    /// When the state was measured: ms of the swarm's common clock, which wraps around.
    #[must_use]
    pub const fn time_ms(&self) -> u32 {
        self.time_ms
    }

    /// The measured state, ticks and ticks/step.
    #[must_use]
    pub const fn state(&self) -> State {
        State { position: self.position, velocity: Vec2 { x: self.velocity[0] as i32, y: self.velocity[1] as i32 } }
    }

    /// The tie-breaker of the step, −127 to 127 (see [`crate::random::tie_breaker`]).
    #[must_use]
    pub const fn tie(&self) -> i8 {
        self.tie
    }
}
