//! The host's end of the PIL protocol (see [`firmware_core::pil`]).
//!
//! A [`Client`] flies an actor on a board over anything that can be read and written: a
//! socket of an emulator, a serial line. A UAV's step is
//!
//! ```no_run
//! # use covey_pil::{Client, PilError, Options};
//! # use firmware_core::{geometry::{State, Vec2}, pil::Setup, message::Message, neighbour_table::Moment};
//! # fn main() -> Result<(), PilError> {
//! # let (state, pois, beacons, features) = (State::default(), [Vec2::default()], [], []);
//! # let broadcast = |_: &[u8]| {};
//! let mut board = Client::tcp("127.0.0.1:4444", Options::default())?;
//! board.hello(Setup { id: 1, seed: 10, argmax: false, step_ms: 2000, half_side: 100 * 1024 })?;
//! let now = Moment { step: 0, time_ms: 0 };
//! for beacon in &beacons {
//!     board.hear(now, state.position, beacon)?;
//! }
//! broadcast(&board.observe(now, state, pois)?.message);
//! for feature in &features {
//!     board.hear(now, state.position, feature)?;
//! }
//! let decision = board.decide(now.step)?;
//! # Ok(())
//! # }
//! ```
//!
//! A request without an answer is sent again, as often as [`Options`] say: the board
//! takes a second one as the first.
#![deny(missing_docs)]
#![forbid(unsafe_code)]

mod client;
mod error;
mod exchange;
mod loopback;
#[cfg(unix)]
pub mod qemu;
mod records;
mod turn;

pub use client::{Board, Client, Heard, Observed};
pub use error::PilError;
pub use exchange::Options;
pub use loopback::Loopback;
pub use turn::Turn;
