//! For `#[serde(with = "covey_report::metrics::nan_as_null")]` on an `f64`: numbers that are not finite are written as
//! `null`, and `null` is read as NaN.

use serde::{Deserialize, Deserializer, Serializer};

/// Writes the number, or `null` when it is not finite.
///
/// # Errors
/// What the serialiser reports.
pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.serialize_none() }
}

/// Reads a number, or NaN for `null`.
///
/// # Errors
/// When the value is neither a number nor `null`.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
