//! A swarm in simulation: nodes against a fleet of simulated autopilots, world after world, compared
//! with the trainer's evaluation of the same worlds.

mod comparison;
mod coverage;
mod error;
mod fleet;
mod fleet_config;
mod fleet_kind;
mod flight;
mod flight_driver;
mod page;
mod reference;
mod run_folder;
mod runner;
mod settings;
mod summary;
mod world_flight;

pub use error::SimulationError;
pub use fleet::{Fleet, FleetError, find_python};
pub use fleet_kind::FleetKind;
pub use page::{Page, PageError};
pub use settings::Simulation;
pub use summary::Summary;
pub use world_flight::WorldFlight;
