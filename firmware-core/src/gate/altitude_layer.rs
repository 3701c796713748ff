//! Altitude layers: what keeps UAVs apart.

/// Altitude of a UAV's layer, mm: `base + (id mod layers) · spacing`. No layers count as one. Training lets UAVs pass
/// through each other; in flight their altitudes keep them apart.
#[must_use]
pub fn altitude_layer_mm(id: u16, base_mm: i32, spacing_mm: u32, layers: u16) -> i32 {
    let layer = i64::from(id.checked_rem(layers).unwrap_or(0));
    let altitude = i64::from(base_mm) + layer * i64::from(spacing_mm);
    i32::try_from(altitude).unwrap_or(i32::MAX)
}
