//! Charts as callers pass them.

use super::error::ReportError;
use serde::{Deserialize, Serialize};

/// Curves over a shared pair of axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// What is drawn: `Coverage index`.
    pub title: String,
    /// Quantity and unit along x: `episodes`.
    pub x_label: String,
    /// Quantity and unit along y: `share of PoIs`.
    pub y_label: String,
    /// Ends of the y axis, for a quantity whose range is known; else (or when they are
    /// no range) it fits the data.
    pub y_range: Option<(f64, f64)>,
    /// The curves, drawn in this order.
    pub series: Vec<Series>,
    /// Levels to compare with.
    pub references: Vec<Reference>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Name in the legend; also chooses the colour.
    pub name: String,
    /// x and y. A value that is not finite interrupts the curve.
    pub points: Vec<(f64, f64)>,
    /// Low and high edge around each point (standard errors, quantiles), if any.
    pub band: Option<Vec<(f64, f64)>>,
}

/// A level that other work reaches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Whose it is: `centroid heuristic`.
    pub name: String,
    /// How high.
    pub y: f64,
}

impl Series {
    /// A noisy curve made legible: the mean of each of about `bins` stretches of
    /// equally many points, with a band of ± one standard deviation inside it.
    /// Curves of up to `bins` points stay as they are. Values that are not finite are
    /// left out.
    #[must_use]
    pub fn binned(name: impl Into<String>, points: &[(f64, f64)], bins: usize) -> Self {
        let name = name.into();
        let finite: Vec<_> = points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        if finite.len() <= bins.max(1) {
            return Self { name, points: finite, band: None };
        }
        let bin = |chunk: &[(f64, f64)]| {
            let n = chunk.len() as f64;
            let mean = |f: &dyn Fn(&(f64, f64)) -> f64| chunk.iter().map(f).sum::<f64>() / n;
            let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
            let deviation = mean(&|p| (p.1 - y).powi(2)).sqrt();
            ((x, y), (y - deviation, y + deviation))
        };
        let (points, band) = finite.chunks(finite.len().div_ceil(bins.max(1))).map(bin).unzip();
        Self { name, points, band: Some(band) }
    }
}

impl Chart {
    /// Checks that every band is as long as its curve.
    pub(super) fn check(&self) -> Result<(), ReportError> {
        let unequal = |s: &&Series| s.band.as_ref().is_some_and(|b| b.len() != s.points.len());
        match self.series.iter().find(unequal) {
            None => Ok(()),
            Some(s) => Err(ReportError::Band {
                chart: self.title.clone(),
                series: s.name.clone(),
                points: s.points.len(),
                band: s.band.as_ref().map_or(0, Vec::len),
            }),
        }
    }
}
