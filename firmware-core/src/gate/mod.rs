//! The safety gate between the actor and the autopilot.
//!
//! At every tick the gate sees the vehicle's telemetry and the setpoint that the actor proposes ([`Inputs`]) and says what may be sent
//! ([`Verdict`]): the actor's setpoint within all limits, a setpoint that holds, a command to return home, or nothing.
//! It takes the vehicle only when the operator asks for it, and once the pilot or a failsafe took over it is silent
//! until the operator asks anew. `docs/safety.md` has every cause with its action and its time.
//!
//! Pure and integer: the same inputs give the same verdicts on every target. All lengths are mm, speeds mm/s,
//! accelerations mm/s², times wrapping ms.
//!
//! ```
//! use firmware_core::gate::{Geofence, Gate, Inputs, Limits, Reason, Vector, Verdict};
//!
//! let fence = Geofence::rectangle(Vector::new(-20_000, -20_000), Vector::new(520_000, 520_000))?;
//! let mut gate = Gate::new(Limits::default(), fence)?;
//! assert_eq!(gate.tick(&Inputs::default()), Verdict::Silent(Reason::NotStarted));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod altitude_layer;
mod approach;
mod boundary;
mod circle;
mod clock;
mod debounce;
mod failsafe;
mod fingerprint;
mod geofence;
mod geofence_error;
mod inputs;
mod limits;
mod monitor;
mod phase;
mod polygon;
mod reason;
mod safety_gate;
mod setpoint_limiter;
pub mod telemetry;
mod vector;
mod verdict;

pub use altitude_layer::altitude_layer_mm;
pub use circle::Circle;

pub use failsafe::{Clock, FailsafeAction, Recovery};
pub use fingerprint::{FINGERPRINT_TICKS, fingerprint};
pub use geofence::Geofence;
pub use geofence_error::{GeofenceError, MAX_CORNERS};
pub use inputs::{FlightMode, Inputs, Measured, Proposal, Request};
pub use limits::{Limits, LimitsError, SwarmLoss};
pub use phase::Phase;
pub use reason::Reason;
pub use safety_gate::Gate;
pub use setpoint_limiter::ROUNDING_MM_S;
pub use vector::{POSITION_LIMIT_MM, RATE_LIMIT, Vector};
pub use verdict::{Limited, Setpoint, Verdict};
