//! From an autopilot's degrees and metres to the map and back, and headings.
//!
//! Navigation stands before the observation and behind the action: it makes the measured state
//! that an [`Agent`](crate::agent::Agent) observes, and tells a vehicle where to point. So it
//! may compute with floats; between observation and action there are none. No function here
//! panics, and each gives the same result on every target.
//!
//! ```
//! use firmware_core::navigation::{LocalFrame, MapScale, heading_centidegrees};
//!
//! // The map's south-west corner at 47° N 8° E, 2.5 m a map unit, 2 s a step.
//! let frame = LocalFrame::new(470_000_000, 80_000_000).ok_or("no frame")?;
//! let scale = MapScale { unit_m: 2.5, step_ms: 2000 };
//! // A vehicle 100 m north of it that flies north-east at 2.5 m/s on each axis.
//! let place = frame.local(470_008_983, 80_000_000).ok_or("too far away")?;
//! let (position, velocity) = (scale.position(place), scale.velocity(2.5, 2.5));
//! assert_eq!((position.to_u().0, position.to_u().1.round()), (0.0, 40.0));
//! assert_eq!(velocity.to_u(), (2.0, 2.0));
//! assert_eq!(heading_centidegrees(2.5, 2.5), Some(4500));
//! # Ok::<(), &str>(())
//! ```

mod frame;
mod heading;
mod scale;

pub use frame::{LATITUDE_LIMIT_E7, LocalFrame, LocalPosition, REACH_MM, degrees_to_e7};
pub use heading::{HEADING_ERROR_RAD, heading_centidegrees, heading_rad};
pub use scale::MapScale;
