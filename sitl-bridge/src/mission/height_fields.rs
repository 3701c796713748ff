//! The fields of heights, checked.

use super::check::Check;
use super::definition::{HeightLimits, Layers};
use super::fault::Fault;
use super::file::AltitudeFile;

impl Check<'_> {
    pub(super) fn layers(&self) -> Result<Layers, Fault> {
        let AltitudeFile { base_m, spacing_m, layers, .. } = self.file.altitude;
        self.within("altitude.base_m", base_m, 2.0, 500.0)?;
        self.within("altitude.spacing_m", spacing_m, 0.0, 100.0)?;
        self.within("altitude.layers", layers, 1, 1000)?;
        let highest_m = base_m + f64::from(layers - 1) * spacing_m;
        if highest_m > 1000.0 {
            return Err(
                self.fault("altitude.layers", format!("puts the highest layer at {highest_m} m; use 1000 m at most"))
            );
        }
        Ok(Layers { base_m, spacing_m, count: layers })
    }

    pub(super) fn heights(&self) -> Result<HeightLimits, Fault> {
        let AltitudeFile { highest_above_home_m, home_within_m, check_m, .. } = self.file.altitude;
        self.within("altitude.highest_above_home_m", highest_above_home_m, 5.0, 1000.0)?;
        self.within("altitude.home_within_m", home_within_m, 1.0, 1000.0)?;
        self.within("altitude.check_m", check_m, 1.0, 1000.0)?;
        Ok(HeightLimits { highest_above_home_m, home_within_m, check_m })
    }
}
