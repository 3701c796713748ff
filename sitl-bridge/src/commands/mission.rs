//! `mission`: a world of the scenario as a mission file.

use crate::mission::{Mission, Origin};
use covey_env::{Scenario, World};
use miette::{IntoDiagnostic as _, Result, WrapErr as _};

/// Arguments of `mission`.
#[derive(clap::Args)]
pub(crate) struct WriteMission {
    /// Index of the world.
    #[arg(long, default_value_t = 0)]
    world: u64,
    /// Seed of the worlds.
    #[arg(long, default_value_t = 777)]
    seed: u64,
    /// Number of PoIs.
    #[arg(long, default_value_t = 120)]
    pois: usize,
    /// Latitude of the map's south-west corner, degrees.
    #[arg(long, default_value_t = Origin::default().lat, allow_hyphen_values = true)]
    lat: f64,
    /// Longitude of the map's south-west corner, degrees.
    #[arg(long, default_value_t = Origin::default().lon, allow_hyphen_values = true)]
    lon: f64,
    /// Altitude of the map above mean sea level, m.
    #[arg(long, default_value_t = Origin::default().alt_m, allow_hyphen_values = true)]
    alt: f64,
}

impl WriteMission {
    /// Prints the mission.
    ///
    /// # Errors
    /// No world or no map can be made of these numbers.
    pub fn run(self) -> Result<()> {
        let scenario = Scenario { pois: self.pois, ..Scenario::default() };
        let mut world = World::new(&scenario).into_diagnostic()?;
        world.reset(self.seed, self.world);
        let origin = Origin { lat: self.lat, lon: self.lon, alt_m: self.alt };
        let mission = Mission::of_world(&world, origin).into_diagnostic().wrap_err("no map can be laid there")?;
        print!("{}", mission.to_toml(&format!("World {} of seed {}", self.world, self.seed)));
        Ok(())
    }
}
